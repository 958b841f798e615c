// Test pairs by kind of shapes and class of relative pose.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "tandem/narrowphase/shape.h"

namespace tandem::reference {

/// Classes of relative poses. "Size" is the smaller shape's, about 1 except in `hard`.
enum class PairClass : std::uint8_t {
  separated,  ///< a gap of 0.1 of the size
  near,       ///< |gap| log-uniform in 1e-12..1e-3 of the size, of either sign
  shallow,    ///< overlapping by log-uniform 1e-6..1e-2 of the size
  deep,       ///< centres within each other's inscribed balls, one in eight concentric
  hard,       ///< faces and edges exactly or almost parallel, identical poses, size ratio 1e4, coordinates 1e5..1e6,
              ///< needles and plates of aspect 1e4
};
inline constexpr std::array all_pair_classes = {PairClass::separated, PairClass::near, PairClass::shallow,
                                                PairClass::deep, PairClass::hard};
std::string_view name(PairClass c);

/// A shape of a pair: its kind, and its number of points if it is a hull.
struct ShapeRecipe {
  ShapeKind kind;
  int points = 0;  ///< convex only; 0 lets the pair choose 4..32
};

enum class PairKind : std::uint8_t {
  sphere_sphere,
  sphere_box,
  sphere_capsule,
  capsule_capsule,
  box_box,
  capsule_box,
  halfspace_box,
  cylinder_cylinder,
  box_cylinder,
  cone_cone,
  box_cone,
  cylinder_cone,
  ellipsoid_ellipsoid,
  box_ellipsoid,
  hull32_hull32,
  hull256_hull256,
  hull32_box,
  hull32_cylinder,
  triangle_box,
  triangle_triangle,
};
inline constexpr std::size_t pair_kinds = 20;
std::string_view name(PairKind kind);
std::array<ShapeRecipe, 2> recipes(PairKind kind);

struct PosedPair {
  Shape a;
  Pose pose_a;
  Shape b;
  Pose pose_b;
};

/// The index-th pair of a kind and class: the same bits on every machine. Takes 0.1 to 10 ms where it must be placed.
PosedPair make_pair(PairKind kind, PairClass pair_class, std::uint64_t index);
/// The index-th pair of any two convex kinds, not both half-spaces (throws std::invalid_argument).
PosedPair make_pair(const ShapeRecipe& a, const ShapeRecipe& b, PairClass pair_class, std::uint64_t index);

/// The unit of relative errors: the larger shape's size.
double size(const PosedPair& pair);

}  // namespace tandem::reference
