// Meshes by formula and the scene of all kinds of shapes that is made of them.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "tandem/engine/scene.h"

namespace tandem::bench {

struct NamedShape {
  std::string name;
  Shape shape;
};

/// Four meshes of some 6,000 triangles that fit a ball of radius 1: a smooth solid with shallow hollows, a torus, a
/// threaded bolt, and an open sheet of hills.
std::vector<NamedShape> large_meshes();

/// Sphere, capsule, box, cylinder, cone, ellipsoid and a hull of 32 points, about `radius` in size.
std::vector<NamedShape> convex_shapes(double radius);

/// Bodies of eight kinds in turn, about half a metre in radius each: the seven above and meshes of 1,200 to 5,000
/// triangles. Put anywhere in a cube, so that each overlaps three others or so.
Scene mixed_scene(std::size_t bodies);

/// The bodies of `mixed_scene` over a floor, with room between them.
Scene falling_mixed_scene(std::size_t bodies);

}  // namespace tandem::bench
