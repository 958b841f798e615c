// Meshes for tests.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "tandem/narrowphase/shape.h"

namespace tandem::test {

/// A closed torus about z of 2 * segments * sides triangles.
inline Mesh torus(double ring, double tube, int segments, int sides) {
  Mesh mesh;
  mesh.solid = true;
  for (int i = 0; i < segments; ++i)
    for (int j = 0; j < sides; ++j) {
      const double u = 2 * std::numbers::pi * i / segments, v = 2 * std::numbers::pi * j / sides;
      const double r = ring + tube * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
      const auto at = [&](int a, int b) { return static_cast<std::uint32_t>(a % segments * sides + b % sides); };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

/// A closed box with its centre at the origin, every face divided into n x n squares.
inline Mesh box_mesh(const Vec3& size, int n = 1) {
  Mesh mesh;
  mesh.solid = true;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int a, int b) {
            Vec3 p;
            p[axis] = side * 0.5;
            p[(axis + 1) % 3] = static_cast<double>(a) / n - 0.5;
            p[(axis + 2) % 3] = static_cast<double>(b) / n - 0.5;
            mesh.vertices.push_back(p.cwiseProduct(size));
            return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
          };
          const auto a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
          if (side > 0) {
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
          } else {
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({a, d, c});
          }
        }
  return mesh;
}

/// A solid with a hollow: the inner one's triangles, reversed, are its walls.
inline Mesh with_hollow(Mesh outer, const Mesh& inner) {
  const auto first = static_cast<std::uint32_t>(outer.vertices.size());
  outer.vertices.insert(outer.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  for (const auto& t : inner.triangles) outer.triangles.push_back({t[0] + first, t[2] + first, t[1] + first});
  return outer;
}

/// A solid of the height, centred at z = 0, over a polygon that is cut into the triangles `caps`, anticlockwise.
inline Mesh prism(const std::vector<std::array<double, 2>>& polygon,
                  const std::vector<std::array<std::uint32_t, 3>>& caps, double height) {
  Mesh mesh;
  mesh.solid = true;
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (const double z : {-height / 2, height / 2})
    for (const auto& p : polygon) mesh.vertices.emplace_back(p[0], p[1], z);
  for (const auto& t : caps) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.triangles.push_back({i, next, next + n});
    mesh.triangles.push_back({i, next + n, i + n});
  }
  return mesh;
}

/// A random rotation.
inline Quat random_turn(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Quat{normal(random), normal(random), normal(random), normal(random)}.normalized();
}

inline Vec3 random_point(std::mt19937_64& random, double reach) {
  std::uniform_real_distribution<double> uniform(-reach, reach);
  return {uniform(random), uniform(random), uniform(random)};
}

inline Pose random_pose(std::mt19937_64& random, double reach) {
  const Quat turn = random_turn(random);
  return Pose::from(turn, random_point(random, reach));
}

}  // namespace tandem::test
