#include "meshes/contacts/patch_normal.h"

#include <algorithm>
#include <cmath>

#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

// What rounding may make of the area of a patch's curve: its points lie in both triangles' planes to rounding, the less
// exactly the flatter these cross.
double noise_of(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings) {
  const auto normal = [&](bool of_a, std::uint32_t t) {
    const auto p = m.corners(of_a, t);
    return unit((p[1] - p[0]).cross(p[2] - p[0]));
  };
  const double off = 8 * epsilon * (m.a.half + m.b.half).norm() + m.frame.delta();
  double noise = 0;
  WorkMeter meter(m.limit);
  for (const std::uint32_t k : patch.crossings) {
    meter.spend();
    const Crossing& c = crossings[k];
    const double length = (c.end[1].point - c.end[0].point).norm();
    const double sine = normal(true, c.triangles[0]).cross(normal(false, c.triangles[1])).norm();
    if (length > 0) noise += length * off / sine;
  }
  return noise;
}

// The one plane of a mesh's triangles of a patch that faces the other along n; nullptr if there are several.
const Facet* sole_face(std::span<const Facet> facets, const Vec3& n, double slack) {
  constexpr double on_its_side = 0.1;
  const Facet* face = nullptr;
  for (const Facet& f : facets) {
    if (!(f.n.dot(n) > on_its_side)) continue;
    if (face == nullptr) face = &f;
    for (const Vec3& v : f.p)
      if (std::abs(face->n.dot(v - face->p[0])) > slack) return nullptr;
  }
  return face;
}

}  // namespace

PatchNormal normal_of(const PosedMeshes& m, const Patch& patch, const Facets& facets,
                      std::span<const Crossing> crossings) {
  const Vec3 base = crossings[patch.crossings[0]].end[0].point;
  Vec3 area = Vec3::Zero(), open = Vec3::Zero(), sides = Vec3::Zero();
  double length = 0;
  WorkMeter meter(m.limit);
  for (const std::uint32_t c : patch.crossings) {
    meter.spend();
    const Vec3 p = crossings[c].end[0].point - base, q = crossings[c].end[1].point - base;
    area += p.cross(q) / 2;
    open += q - p;
    length += (q - p).norm();
  }
  // A curve that closes has an area; a slit or an open curve (of a surface with a border) has no direction.
  // Two edges that cross make a sliver with the right normal, however thin; a wide patch that thin is noise.
  const double least = patch.vertices.empty() ? tolerance::sliver_patch : tolerance::wide_patch, ample = 1e3;
  if (open.norm() <= tolerance::flush * length &&
      (area.norm() > least * length * length || area.norm() > ample * noise_of(m, patch, crossings)))
    return {unit(area), true, area};
  for (const bool of_a : {true, false})
    for (const Facet& f : facets[of_a ? 1 : 0]) meter.spend(), sides += f.n;
  return {sides.norm() > tolerance::flush ? Vec3(sides.normalized()) : Vec3(Vec3::Zero()), false, area};
}

Vec3 normal_of_face(const PosedMeshes& m, const PatchPoints& points, const Vec3& n) {
  const double slack = tolerance::in_plane * (m.a.half + m.b.half).norm();
  const Facet *of_a = sole_face(points.facets[1], n, slack), *of_b = sole_face(points.facets[0], n, slack);
  if (of_a != nullptr && of_b != nullptr) {
    // Of two that which less has come through.
    double beyond_a = 0, beyond_b = 0;
    const auto include = [&](std::span<const Candidate> some) {
      for (const Candidate& c : some) {
        beyond_a = std::max(beyond_a, of_a->n.dot(of_a->p[0] - c.point));
        beyond_b = std::max(beyond_b, of_b->n.dot(c.point - of_b->p[0]));
      }
    };
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) include(points.vertices[k]), include(points.edges[k]);
    return beyond_a <= beyond_b ? of_a->n : of_b->n;
  }
  if (of_a == nullptr && of_b == nullptr) return n;
  return of_a != nullptr ? of_a->n : of_b->n;
}

}  // namespace tandem
