// A pair as the relations change it: shapes as a user gives them, so that they can be scaled, permuted and written out.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "random.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::relations {

using reference::Random;

/// In the order of ShapeKind.
using ShapeData = std::variant<Sphere, Box, Capsule, Cylinder, Cone, Ellipsoid, HalfSpace, Convex, Triangle, Mesh, Plane>;

struct PosedShape {
  ShapeData shape;
  Pose pose;
  double rounding = 0;  ///< metres; the radius of a ball about each of its points
  ShapeKind kind() const { return static_cast<ShapeKind>(shape.index()); }
};

struct PosedPair {
  PosedShape a, b;
  double margin = 0;       ///< metres; that of the requests with a margin
  std::uint64_t seed = 0;  ///< of the random numbers that a relation draws
};

Shape make_shape(const ShapeData& data);
Shape make_shape(const PosedShape& posed);
/// What a checked shape was made of, but for the order of a hull's vertices.
ShapeData data_of(const Shape& shape);

/// How far its points lie from the origin of its frame, at most (a half-space: its offset).
double reach(const ShapeData& data);
double reach(const PosedShape& posed);
/// The unit of a pair's relative errors, metres: how far the shapes and the translation between them reach.
double unit_of(const PosedPair& pair);

/// All lengths times `factor`.
void scale(ShapeData& data, double factor);
void scale(PosedPair& pair, double factor);
/// May every length be scaled by `factor` and stay within what shapes and poses admit, every bit kept?
bool can_scale(const PosedPair& pair, double factor);

/// The pair as a record for `tandem query`, every number to its last bit, in one line.
std::string record(const PosedPair& pair, const std::string& id);

}  // namespace tandem::relations
