// The least depth by descents that know nothing of how it was found.
#include <algorithm>
#include <utility>
#include <vector>

#include "checks.h"
#include "other_calls.h"
#include "tandem/narrowphase/clearance.h"

namespace tandem::relations {
namespace {

// Normals of some planes through vertices, in the shape's frame: triangles of a mesh, else any three vertices.
std::vector<Vec3> some_normals(const ShapeData& data, Random& random) {
  constexpr int some = 16;
  std::vector<Vec3> normals;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) { normals.push_back((b - a).cross(c - a)); };
  const auto any = [&](std::size_t count) { return static_cast<std::size_t>(random.below(static_cast<int>(count))); };
  if (const auto* const mesh = std::get_if<Mesh>(&data)) {
    for (int k = 0; k < some; ++k) {
      const auto& t = mesh->triangles[any(mesh->triangles.size())];
      add(mesh->vertices[t[0]], mesh->vertices[t[1]], mesh->vertices[t[2]]);
    }
  } else if (const auto* const hull = std::get_if<Convex>(&data)) {
    for (int k = 0; k < some; ++k) {
      const std::size_t i = any(hull->vertices.size()), j = any(hull->vertices.size());
      add(hull->vertices[i], hull->vertices[j], hull->vertices[any(hull->vertices.size())]);
    }
  } else if (const auto* const triangle = std::get_if<Triangle>(&data)) {
    add(triangle->vertices[0], triangle->vertices[1], triangle->vertices[2]);
  }
  return normals;
}

// Directions in which the bodies may be separated soonest: axes, normals, random ones.
std::vector<Vec3> directions(const Case& c, Random& random) {
  std::vector<Vec3> found;
  for (const PosedShape* const s : {&c.pair.a, &c.pair.b}) {
    for (int k = 0; k < 3; ++k) found.push_back(s->pose.rotation.col(k));
    for (const Vec3& n : some_normals(s->shape, random))
      if (n.stableNorm() > 0) found.push_back(s->pose.rotation * n.stableNormalized());
  }
  for (int k = 0; k < 8; ++k) found.push_back(random.direction());
  const std::size_t count = found.size();
  for (std::size_t i = 0; i < count; ++i) found.push_back(-found[i]);
  return found;
}

}  // namespace

// No translation along a direction is shorter than the depth: the shortest are searched by trial.
std::string least_depth(const Case& c, Random& random) {
  const PairAnswer& r = c.answers.distance;
  if (!c.answers.collide || !c.a.is_bounded() || !c.b.is_bounded()) return {};
  const Vec3 origin = c.pair.a.pose.translation;
  const Pose a{c.pair.a.pose.rotation, Vec3::Zero()}, b{c.pair.b.pose.rotation, c.pair.b.pose.translation - origin};
  const double allowed = -r.signed_distance - r.error_bound - 4 * rounding * c.unit;
  using Trial = std::pair<double, Vec3>;
  const auto trial = [&](const Vec3& n) { return Trial(separation_along(c.a, a, c.b, b, n), n); };
  std::vector<Trial> trials;
  for (const Vec3& n : directions(c, random)) trials.push_back(trial(n));
  const bool convex = c.a.is_convex() && c.b.is_convex();
  const std::size_t descents = std::min<std::size_t>(convex ? 2 : 1, trials.size());
  std::partial_sort(trials.begin(), trials.begin() + static_cast<std::ptrdiff_t>(descents), trials.end(),
                    [](const Trial& p, const Trial& q) { return p.first < q.first; });
  for (std::size_t k = 0; k < descents; ++k) {
    Trial best = trials[k];
    int left = convex ? 120 : 24;
    for (double step = 0.3; left > 0; step *= 0.4) {
      const Trial before = best;
      for (int i = 0; i < 6; ++i, --left) {
        const Vec3 aside = (i % 2 == 0 ? step : -step) * Vec3::Unit(i / 2);
        const Trial next = trial((best.second + aside).normalized());
        if (next.first < best.first) best = next;
      }
      if (best.first < before.first) step /= 0.4;
    }
    if (best.first < allowed)
      return say("moving by ", best.first, " along ", best.second.transpose(), " separates, the depth is ",
                 -r.signed_distance, " +- ", r.error_bound);
  }
  return {};
}

}  // namespace tandem::relations
