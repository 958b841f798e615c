// Meshes of tori, cones, bolts, nuts and bowls.
#include "scene/mesh_generators.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace tandem {
namespace {

using Ring = std::vector<Vec3>;

/// Rings of equally many points, each counter-clockwise from +z, listed so that the outside runs upwards. Without poles
/// the last ring is joined to the first.
struct Poles {
  Vec3 first;
  Vec3 last;
};

Mesh join_rings(const std::vector<Ring>& rings, const std::optional<Poles>& poles) {
  Mesh mesh;
  mesh.solid = true;
  const std::size_t around = rings.front().size();
  for (const Ring& ring : rings) mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  const auto vertex = [&](std::size_t ring, std::size_t i) {
    return static_cast<std::uint32_t>(ring % rings.size() * around + i % around);
  };
  const std::size_t bands = poles ? rings.size() - 1 : rings.size();
  for (std::size_t band = 0; band < bands; ++band)
    for (std::size_t i = 0; i < around; ++i) {
      const std::uint32_t a = vertex(band, i), b = vertex(band, i + 1);
      const std::uint32_t c = vertex(band + 1, i + 1), d = vertex(band + 1, i);
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  if (poles) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(poles->first);
    mesh.vertices.push_back(poles->last);
    for (std::size_t i = 0; i < around; ++i) {
      mesh.triangles.push_back({first, vertex(0, i + 1), vertex(0, i)});
      mesh.triangles.push_back({first + 1, vertex(rings.size() - 1, i), vertex(rings.size() - 1, i + 1)});
    }
  }
  return mesh;
}

Ring circle(double radius, double z, int segments) {
  Ring ring;
  for (int i = 0; i < segments; ++i) {
    const CosSin t = cos_sin_of_turn(i, segments);
    ring.emplace_back(radius * t.cos, radius * t.sin, z);
  }
  return ring;
}

double apothem(double corner_radius) { return corner_radius * std::sqrt(0.75); }

Ring hexagon(double corner_radius, double z, int segments) {
  const int per_side = segments / 6;
  Ring ring;
  for (int i = 0; i < segments; ++i) {
    // The side's middle is half a side ahead of its first corner.
    const double off_middle = cos_sin_of_turn(2 * (i % per_side) - per_side, 2 * segments).cos;
    const CosSin t = cos_sin_of_turn(i, segments);
    const double radius = apothem(corner_radius) / off_middle;
    ring.emplace_back(radius * t.cos, radius * t.sin, z);
  }
  return ring;
}

// The flats are a quarter of the pitch: every column of ring points meets each of them.
constexpr int rows_per_turn = 4;

int thread_rows(const Thread& thread) { return thread.turns * rows_per_turn; }

/// Ring `row` (0 the lowest) of a thread that begins at z0.
Ring thread_ring(const Thread& thread, int row, double z0, int segments) {
  Ring ring;
  for (int i = 0; i < segments; ++i) {
    const double turns = static_cast<double>(row) / rows_per_turn - static_cast<double>(i) / segments;
    const double phase = turns - std::floor(turns);
    const double from_crest = std::abs(2 * phase - 1);
    const double height = std::clamp((0.75 - from_crest) / 0.5, 0.0, 1.0);
    const double radius = thread.root_radius + height * (thread.crest_radius - thread.root_radius);
    const CosSin t = cos_sin_of_turn(i, segments);
    ring.emplace_back(radius * t.cos, radius * t.sin, z0 + row * thread.pitch / rows_per_turn);
  }
  return ring;
}

}  // namespace

CosSin cos_sin_of_turn(int numerator, int denominator) {
  const std::int64_t n = denominator;
  const std::int64_t quarters = 4 * ((numerator % n + n) % n);
  const std::int64_t quadrant = quarters / n, rest = quarters % n;
  const bool mirrored = 2 * rest > n;  // beyond an eighth of a turn the complement's series converges faster
  const double x = std::numbers::pi / 2 * (static_cast<double>(mirrored ? n - rest : rest) / static_cast<double>(n)),
               xx = x * x;
  double cos = 0, sin = 0;
  for (int k = 18; k >= 2; k -= 2) {
    cos = -(1 + cos) * xx / (k * (k - 1));
    sin = -(1 + sin) * xx / ((k + 1) * k);
  }
  cos = 1 + cos;
  sin = x + x * sin;
  if (mirrored) std::swap(cos, sin);
  switch (quadrant) {
    case 0:
      return {cos, sin};
    case 1:
      return {-sin, cos};
    case 2:
      return {-cos, -sin};
    default:
      return {sin, -cos};
  }
}

Mesh make_torus(double ring_radius, double tube_radius, int segments, int sides) {
  std::vector<Ring> rings;
  for (int side = 0; side < sides; ++side) {
    const CosSin t = cos_sin_of_turn(side, sides);
    rings.push_back(circle(ring_radius + tube_radius * t.cos, tube_radius * t.sin, segments));
  }
  return join_rings(rings, {});
}

Mesh make_cone(double radius, double height, int segments, int bands) {
  std::vector<Ring> rings;
  for (int band = 0; band < bands; ++band) {
    const double up = static_cast<double>(band) / bands;
    rings.push_back(circle(radius * (1 - up), height * up, segments));
  }
  return join_rings(rings, Poles{Vec3::Zero(), Vec3(0, 0, height)});
}

Mesh make_bolt(const BoltSize& size) {
  const Thread& thread = size.thread;
  const int n = size.segments;
  const double chamfer = thread.pitch / 4;
  const double length = 2 * chamfer + thread.turns * thread.pitch + size.head_height;
  const double bottom = -length / 2, top = length / 2, neck = top - size.head_height;
  std::vector<Ring> rings{circle(0.9 * thread.root_radius, bottom, n)};
  for (int row = 0; row <= thread_rows(thread); ++row) rings.push_back(thread_ring(thread, row, bottom + chamfer, n));
  rings.push_back(circle(thread.root_radius, neck, n));
  rings.push_back(hexagon(size.head_radius, neck, n));
  rings.push_back(hexagon(size.head_radius, top - chamfer, n));
  rings.push_back(circle(0.9 * apothem(size.head_radius), top, n));
  return join_rings(rings, Poles{Vec3(0, 0, bottom), Vec3(0, 0, top)});
}

Mesh make_nut(const NutSize& size) {
  const Thread& thread = size.thread;
  const int n = size.segments;
  const double chamfer = thread.pitch / 4;
  const double top = thread.turns * thread.pitch / 2 + chamfer;
  const double face = 0.95 * apothem(size.corner_radius);
  std::vector<Ring> rings{circle(face, -top, n), hexagon(size.corner_radius, chamfer - top, n),
                          hexagon(size.corner_radius, top - chamfer, n), circle(face, top, n),
                          circle(thread.root_radius, top, n)};
  for (int row = thread_rows(thread); row >= 0; --row) rings.push_back(thread_ring(thread, row, chamfer - top, n));
  rings.push_back(circle(thread.root_radius, -top, n));
  return join_rings(rings, {});
}

double bowl_height(const BowlSize& size, double distance) {
  const double r = size.sphere_radius;
  return r - std::sqrt(std::max(0.0, r * r - distance * distance));
}

double bowl_sagitta(const BowlSize& size) {
  // A chord c of a circle of radius r has a sagitta below c^2 / (4 r) up to half a circle; the facets' chords in both
  // directions add up.
  const double around = 2 * std::numbers::pi * size.rim_radius / size.segments;
  const double along =
      std::hypot(size.rim_radius / size.bands, bowl_height(size, size.rim_radius) -
                                                   bowl_height(size, size.rim_radius - size.rim_radius / size.bands));
  return (around * around + along * along) / (4 * size.sphere_radius);
}

Mesh make_bowl(const BowlSize& size) {
  const int n = size.segments;
  const double outer = size.rim_radius + size.thickness;
  std::vector<Ring> rings{circle(outer, -size.thickness, n), circle(outer, bowl_height(size, size.rim_radius), n)};
  for (int band = size.bands; band >= 1; --band) {
    const double radius = size.rim_radius * band / size.bands;
    rings.push_back(circle(radius, bowl_height(size, radius), n));
  }
  return join_rings(rings, Poles{Vec3(0, 0, -size.thickness), Vec3::Zero()});
}

}  // namespace tandem
