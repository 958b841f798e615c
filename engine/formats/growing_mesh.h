// Builds the mesh of a file, vertex by vertex and triangle by triangle.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "formats/input_limits.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

// Functions by which readers add vertices and triangles. `fail(found, allowed)` throws, with the reader's position in
// the file, where limits::mesh_vertices or mesh_triangles would be exceeded.

template <typename Fail>
void add_vertex(Mesh& mesh, const Vec3& vertex, const Fail& fail) {
  if (mesh.vertices.size() == limits::mesh_vertices)
    fail("one more vertex", "at most " + std::to_string(limits::mesh_vertices) + " in all");
  mesh.vertices.push_back(vertex);
}

template <typename Fail>
void add_triangle(Mesh& mesh, const std::array<std::uint32_t, 3>& triangle, const Fail& fail) {
  if (mesh.triangles.size() == limits::mesh_triangles)
    fail("one more triangle", "at most " + std::to_string(limits::mesh_triangles) + " in all");
  mesh.triangles.push_back(triangle);
}

/// A polygon, corner by corner: its triangles are a fan from the first corner.
class Fan {
 public:
  std::size_t corners() const { return corners_; }
  template <typename Fail>
  void add(Mesh& mesh, std::uint32_t corner, const Fail& fail) {
    if (corners_ > 2) triangle_[1] = triangle_[2];
    triangle_[std::min<std::size_t>(corners_, 2)] = corner;
    if (++corners_ > 2) add_triangle(mesh, triangle_, fail);
  }

 private:
  std::array<std::uint32_t, 3> triangle_{};
  std::size_t corners_ = 0;
};

/// Merges corners with equal coordinates into one vertex, numbered in the order of their first appearance.
class Welder {
 public:
  explicit Welder(Mesh& mesh) : mesh_(mesh) {}
  template <typename Fail>
  std::uint32_t add(const Vec3& v, const Fail& fail) {
    // Adding zero makes -0 and 0 the same key.
    const std::array<double, 3> key{v.x() + 0.0, v.y() + 0.0, v.z() + 0.0};
    const auto [found, is_new] = numbers_.emplace(key, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) add_vertex(mesh_, v, fail);
    return found->second;
  }

 private:
  Mesh& mesh_;
  std::map<std::array<double, 3>, std::uint32_t> numbers_;
};

}  // namespace tandem
