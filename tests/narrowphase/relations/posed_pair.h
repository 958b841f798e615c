// A pair in the form in which relations modify it: shapes as a user specifies them, so that they can be scaled,
// permuted and printed.
#pragma once
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <variant>

#include "random.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::relations {

using reference::Random;

/// 10^-u, u uniform in [least, most].
inline double small(Random& r, double least, double most) { return std::pow(10.0, -r.in(least, most)); }
inline double small(Random& r, double most) { return small(r, 0, most); }

/// In the order of ShapeKind.
using ShapeData =
    std::variant<Sphere, Box, Capsule, Cylinder, Cone, Ellipsoid, HalfSpace, Convex, Triangle, Mesh, Plane, Voxels>;

struct PosedShape {
  ShapeData shape;
  Pose pose;
  double rounding = 0;  ///< metres, see Shape::rounded
  ShapeKind kind() const { return static_cast<ShapeKind>(shape.index()); }
};

struct PosedPair {
  PosedShape a, b;
  double margin = 0;       ///< metres; for the requests with a margin
  std::uint64_t seed = 0;  ///< for the random numbers of the relations
};

Shape make_shape(const ShapeData& data);
Shape make_shape(const PosedShape& posed);
/// The data from which a shape was made, except for the order of a hull's vertices.
ShapeData data_of(const Shape& shape);

/// The largest distance of the shape's points from its origin (for a half-space: its offset).
double reach(const ShapeData& data);
double reach(const PosedShape& posed);
/// The unit of a pair's relative errors, metres: the extent of the shapes plus the translation between them.
double unit_of(const PosedPair& pair);

/// Scales all lengths by `factor`.
void scale(ShapeData& data, double factor);
void scale(PosedPair& pair, double factor);
/// True if all lengths can be scaled by `factor` exactly, within the limits of shapes and poses.
bool can_scale(const PosedPair& pair, double factor);

/// Applies change(pair), unless shapes would then be smaller than they are allowed to be, or otherwise refused.
template <class Change>
void change_if_allowed(PosedPair& pair, const Change& change) {
  PosedPair changed = pair;
  try {
    change(changed);
    make_shape(changed.a), make_shape(changed.b);
  } catch (const std::invalid_argument&) {
    return;
  }
  pair = changed;
}

/// The pair as a record for `tandem query`, in one line, with all digits.
std::string record(const PosedPair& pair, const std::string& id);

}  // namespace tandem::relations
