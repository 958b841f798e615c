// Points that two meshes share.
#include "meshes/depth/shared_places.h"

#include <array>

#include "meshes/traversal/meeting_pairs.h"
#include "meshes/traversal/point_in_mesh.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"

namespace tandem {
namespace {

Corners placed(const Posed& mesh, std::uint32_t t) {
  Corners c = mesh_of(mesh.shape).corners(t);
  for (Vec3& v : c) v = mesh.pose * v;
  return c;
}

// Adds the points where edges of p cross the plane of q, between corners on either side, within the triangle q.
void add_crossings(const Corners& p, const Corners& q, Vec3& sum, int& count) {
  const Vec3 n = area_vector(q);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &from = p[k], &to = p[(k + 1) % 3];
    const double x = n.dot(from - q[0]), y = n.dot(to - q[0]);
    if (!(x * y < 0)) continue;
    const Vec3 at = from + x / (x - y) * (to - from);
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) inside = inside && n.dot((q[(i + 1) % 3] - q[i]).cross(at - q[i])) >= 0;
    if (inside) sum += at, ++count;
  }
}

// A point near both if no edge crosses, as for triangles that only touch.
SharedPlace crossing(const Corners& p, const Corners& q) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  add_crossings(p, q, sum, count);
  add_crossings(q, p, sum, count);
  return {count > 0 ? Vec3(sum / count) : Vec3((p[0] + p[1] + p[2] + q[0] + q[1] + q[2]) / 6),
          -unit(area_vector(p)) - unit(area_vector(q))};
}

void add_inside(const Posed& outer, const Posed& inner, const WorkLimit* limit, std::vector<SharedPlace>& places) {
  const MeshModel &o = mesh_of(outer.shape), &i = mesh_of(inner.shape);
  if (!o.solid) return;
  for (const MeshModel::Component& component : i.components()) {
    const Vec3& v = i.vertices[component[0]];
    if (is_inside(o, outer.pose, v, inner.pose, limit)) places.push_back({inner.pose * v, Vec3::Zero()});
  }
}

}  // namespace

std::vector<SharedPlace> shared_places(const Posed& a, const Posed& b, std::size_t most, const WorkLimit* limit) {
  constexpr std::size_t most_pairs = 1024;  // distributed over all crossing ones
  std::vector<TrianglePair> pairs;
  const auto take = [&](const TrianglePair& pair) {
    pairs.push_back(pair);
    return pairs.size() < most_pairs;
  };
  each_meeting_pair(a, b, limit, take, {});
  std::vector<SharedPlace> places;
  const std::size_t step = pairs.size() / most + 1;
  for (std::size_t k = 0; k < pairs.size(); k += step)
    places.push_back(crossing(placed(a, pairs[k][0]), placed(b, pairs[k][1])));
  if (places.empty()) add_inside(a, b, limit, places);
  if (places.empty()) add_inside(b, a, limit, places);
  return places;
}

}  // namespace tandem
