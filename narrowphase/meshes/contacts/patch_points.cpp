#include "meshes/contacts/patch_points.h"

#include <algorithm>
#include <array>

#include "manifold/patch_collector.h"
#include "meshes/contacts/depth_probe.h"
#include "tolerances.h"
#include "triangles/patch_rows.h"

namespace tandem {
namespace {

// The candidates, all of one mesh, farthest out in eight directions along the patch, and the farthest beyond it: of
// those that are as far but for `slack` the farthest along the patch's u.
void choose(std::span<const Candidate> all, const Vec3& n, const Vec3& u, const Vec3& v, double slack, WorkMeter& meter,
            List<Candidate>& chosen) {
  constexpr std::size_t at_once = 256;
  constexpr double lean = tolerance::tie_lean;
  if (all.empty()) return;
  const Vec3 beyond = all.front().of_a ? n : Vec3(-n);
  const std::array<Vec3, 10> directions{u, v, u + v, u - v, -u, -v, -u - v, v - u, beyond, beyond + lean * u};
  DirectionRows rows{};
  for (std::size_t k = 0; k < directions.size(); ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      rows.direction[axis][k] = directions[k][static_cast<Eigen::Index>(axis)];
  static_assert(sizeof(Candidate) % sizeof(double) == 0);
  for (std::size_t first = 0; first < all.size(); first += at_once) {
    meter.spend(at_once / 8);
    find_farthest(rows, directions.size(), all.front().point.data(), sizeof(Candidate) / sizeof(double), first,
                  std::min(all.size(), first + at_once));
  }
  std::array<std::size_t, 10> best;
  for (std::size_t k = 0; k < best.size(); ++k) best[k] = static_cast<std::size_t>(rows.best[k]);
  if (beyond.dot(all[best[8]].point - all[best[9]].point) <= slack) best[8] = best[9];
  for (auto at = best.begin(); at != best.end(); ++at)
    if (std::find(best.begin(), at, *at) == at) chosen.push_back(all[*at]);
}

}  // namespace

void add_points(const PosedMeshes& m, const PatchPoints& points, const Vec3& n, Memory memory,
                std::vector<Contact>& contacts) {
  const double size = (m.a.half + m.b.half).norm(), slack = tolerance::alike * size;
  WorkMeter meter(m.limit);
  const DepthProbe depth(points.facets, n, m.limit, memory);
  List<Candidate> chosen(memory);
  chosen.reserve(40);
  for (const std::size_t of_a : {std::size_t{1}, std::size_t{0}}) {
    choose(points.vertices[of_a], n, depth.u(), depth.v(), slack, meter, chosen);
    choose(points.edges[of_a], n, depth.u(), depth.v(), slack, meter, chosen);
  }
  const std::size_t first = contacts.size();
  double most = 0;
  const auto add = [&](const Vec3& point, double d, std::uint32_t feature) {
    most = std::max(most, d);
    const auto known =
        std::find_if(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
                     [&](const Contact& o) { return (o.point - point).norm() < tolerance::same_place * size; });
    if (known == contacts.end())
      contacts.push_back({point, n, d, feature});
    else
      known->depth = std::max(known->depth, d);
  };
  for (const Candidate& c : chosen) {
    meter.spend();
    if (const double d = depth(c, meter); d >= 0) add(c.point - n * (c.of_a ? d / 2 : -d / 2), d, c.feature);
  }
  const List<const RidgeSpan*> ridges[] = {farthest_spans(points.spans[0], -n, slack, memory),
                                           farthest_spans(points.spans[1], n, slack, memory)};
  for (const RidgeSpan* a : ridges[1])
    for (const RidgeSpan* b : ridges[0])
      if (Vec3 point = Vec3::Zero(); const auto d = overlap_of_ridges(*a, *b, n, slack, point))
        add(point, *d, a->feature);
  // Where the surfaces cross the depth is nothing: such points say little beside the deep ones.
  const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
  contacts.erase(std::remove_if(begin, contacts.end(), [&](const Contact& c) { return c.depth < most / 4; }),
                 contacts.end());
  keep_widest(contacts, first, size, &meter);
}

}  // namespace tandem
