// Meshes of tori, cones, bolts, nuts and bowls.
#pragma once
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Cosine and sine of 2 pi numerator / denominator, denominator > 0, to the last digits. Unlike the C library's they
/// have the same bits on every machine.
struct CosSin {
  double cos;
  double sin;
};
CosSin cos_sin_of_turn(int numerator, int denominator);

// All meshes are solid: watertight, oriented outwards. Axis along z. Metres.

/// 2 segments sides triangles; segments around the axis, sides around the tube.
Mesh make_torus(double ring_radius, double tube_radius, int segments, int sides);

/// Base at z = 0, apex at z = height.
Mesh make_cone(double radius, double height, int segments, int bands);

/// A thread's ridges: a trapezoid with flats of a quarter of the pitch on crest and root, right-handed.
struct Thread {
  double root_radius;   ///< where the profile is at rest
  double crest_radius;  ///< a nut's is smaller than its root's
  double pitch;
  int turns;
};

/// Shaft down, hexagonal head up; the middle of the whole length at the origin. `segments` around, a multiple of 6.
struct BoltSize {
  Thread thread;
  double head_radius;  ///< to the hexagon's corners
  double head_height;
  int segments;
};
Mesh make_bolt(const BoltSize& size);

/// A hexagon with a threaded hole, centred. `segments` around, a multiple of 6.
struct NutSize {
  Thread thread;
  double corner_radius;  ///< to the hexagon's corners
  int segments;
};
Mesh make_nut(const NutSize& size);

/// A cylindrical block, its top hollowed out as a spherical cap whose lowest point is the origin.
struct BowlSize {
  double sphere_radius;  ///< of the cap
  double rim_radius;     ///< of the cap's opening, < sphere_radius
  double thickness;      ///< under the lowest point and beside the rim
  int segments;          ///< around
  int bands;             ///< from the lowest point to the rim
};
Mesh make_bowl(const BowlSize& size);

/// Height of the bowl's ideal surface at a distance from the axis.
double bowl_height(const BowlSize& size, double distance);

/// The ideal surface lies below the mesh's facets by no more than this.
double bowl_sagitta(const BowlSize& size);

}  // namespace tandem
