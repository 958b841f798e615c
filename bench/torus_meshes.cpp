// Meshes of benches that vary the size.
#include "torus_meshes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace tandem::bench {

Mesh bumpy_torus(std::size_t triangles) {
  const auto turns = static_cast<std::uint32_t>(std::max(4.0, std::sqrt(1.5 * static_cast<double>(triangles))));
  const std::uint32_t across = std::max(3u, turns / 3);
  Mesh mesh;
  mesh.solid = true;
  for (std::uint32_t i = 0; i < turns; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / turns, v = 2 * std::numbers::pi * j / across;
      const double radius = 0.3 + 0.02 * std::sin(7 * u) * std::cos(5 * v), out = 1 + radius * std::cos(v);
      mesh.vertices.emplace_back(out * std::cos(u), out * std::sin(u), radius * std::sin(v));
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return (i % turns) * across + j % across; };
  for (std::uint32_t i = 0; i < turns; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

std::vector<std::size_t> mesh_sizes(const Settings& settings) {
  if (!settings.sizes.empty()) return settings.sizes;
  if (settings.quick) return {1'000, 20'000};
  return {1'000, 10'000, 100'000, 1'000'000, 5'000'000};
}

Mesh soup_of(const Mesh& mesh) {
  Mesh out;
  out.solid = mesh.solid;
  std::vector<std::array<std::uint32_t, 3>> triangles = mesh.triangles;
  std::mt19937 random(1);
  for (std::size_t i = triangles.size(); i > 1; --i) std::swap(triangles[i - 1], triangles[random() % i]);
  for (const auto& t : triangles) {
    const auto first = static_cast<std::uint32_t>(out.vertices.size());
    for (const std::uint32_t v : t) out.vertices.push_back(mesh.vertices[v]);
    out.triangles.push_back({first, first + 1, first + 2});
  }
  return out;
}

}  // namespace tandem::bench
