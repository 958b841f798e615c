#include "manifold/patch_collector.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "manifold/manifold.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr double opposing = -0.7;  // cosines of the angle between normals
constexpr double one_side = -0.9999;

using Points = std::pmr::vector<Contact>;

}  // namespace

Vec3 uncommon(const Vec3& axis) {
  const Vec3 across = axis.cross(Vec3(0.3613, 0.4789, 0.8001));
  return across.squaredNorm() > 0.1 ? across : axis.cross(Vec3(0.8171, -0.5471, 0.1829));
}

void keep_widest(std::vector<Contact>& contacts, std::size_t first, double size) {
  const std::span<Contact> p = std::span(contacts).subspan(first);
  const auto by_feature = [](const Contact& x, const Contact& y) { return x.feature < y.feature; };
  if (p.size() <= 1) return;
  const double slack = tolerance::alike * size;
  // What is told apart by less could be one of those kept before: the best but for rounding is less by up to `slack`.
  const double apart = 2 * slack;
  const Vec3 axis = p[0].normal, tie_break = uncommon(axis);
  double most;
  // Of those that are as good as the best but for rounding the one farthest along a direction of its own: where they
  // are in the list may be rounding's doing, too.
  const auto best = [&](auto&& score) {
    most = score(p[0]);
    for (const Contact& c : p) most = std::max(most, score(c));
    std::size_t winner = p.size();
    for (std::size_t i = 0; i < p.size(); ++i)
      if (score(p[i]) >= most - slack &&
          (winner == p.size() || tie_break.dot(p[i].point) > tie_break.dot(p[winner].point)))
        winner = i;
    return winner;
  };
  std::array<std::size_t, 4> kept;
  std::size_t count = 0;
  kept[count++] = best([&](const Contact& c) { return tie_break.dot(c.point); });
  const Vec3 from = p[kept[0]].point;
  const std::size_t second = best([&](const Contact& c) { return (c.point - from).norm(); });
  if (const double length = most; length > apart) {
    kept[count++] = second;
    const Vec3 along = (p[second].point - from) / length, side = axis.cross(along);
    const std::size_t third = best([&](const Contact& c) { return std::abs(side.dot(c.point - from)); });
    if (most > std::max(thin * length, apart)) {
      kept[count++] = third;
      // The fourth: outside the triangle of the three by most.
      const double turn = side.dot(p[third].point - from) >= 0 ? 1.0 : -1.0;
      std::array<Vec3, 3> outward;
      for (std::size_t k = 0; k < 3; ++k)
        outward[k] = -turn * axis.cross(p[kept[(k + 1) % 3]].point - p[kept[k]].point).stableNormalized();
      const std::size_t fourth = best([&](const Contact& c) {
        double out = 0;
        for (std::size_t k = 0; k < 3; ++k) out = std::max(out, outward[k].dot(c.point - p[kept[k]].point));
        return out;
      });
      if (most > std::max(thin * length, apart)) kept[count++] = fourth;
    }
  }
  const std::size_t deepest = best([](const Contact& c) { return c.depth; });
  const double depth = most;
  const auto deepest_kept = std::max_element(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(count),
                                             [&](std::size_t i, std::size_t j) { return p[i].depth < p[j].depth; });
  // One that counts as equal stands for the deepest.
  if (p[*deepest_kept].depth >= depth - slack) {
    p[*deepest_kept].depth = depth;
  } else {
    p[deepest].depth = depth;
    if (count < kept.size()) {
      kept[count++] = deepest;
    } else {
      // It takes the place of the one nearest to it.
      const auto away = [&](std::size_t i) { return (p[i].point - p[deepest].point).norm(); };
      const double nearest = away(
          *std::min_element(kept.begin(), kept.end(), [&](std::size_t i, std::size_t j) { return away(i) < away(j); }));
      std::size_t* least = nullptr;
      for (std::size_t& i : kept)
        if (away(i) <= nearest + slack && (!least || tie_break.dot(p[i].point) < tie_break.dot(p[*least].point)))
          least = &i;
      *least = deepest;
    }
  }
  std::array<Contact, 4> widest;  // some of them may stand where others go
  for (std::size_t k = 0; k < count; ++k) widest[k] = p[kept[k]];
  std::copy_n(widest.begin(), count, p.begin());
  std::sort(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(count), by_feature);
  contacts.resize(first + count);
}

void PatchCollector::add(std::uint32_t t, std::span<const Contact> contacts) {
  for (std::uint32_t k = 0; k < contacts.size(); ++k) {
    all_.push_back(contacts[k]);
    all_.back().feature = t * 64 + k;
  }
}

void PatchCollector::finish(const Vec3& centre, bool solid, std::vector<Contact>& out) {
  // Deeper ones found patches; of equals (to rounding, and none are nearer to touching than these) the one whose
  // triangle comes first.
  struct Place {
    double depth;
    std::uint32_t feature, at;
  };
  std::pmr::vector<Place> order(&memory_);
  order.reserve(all_.size());
  for (std::uint32_t i = 0; i < all_.size(); ++i)
    order.push_back({std::round(all_[i].depth / (tolerance::same_depth * size_)), all_[i].feature, i});
  std::sort(order.begin(), order.end(), [](const Place& x, const Place& y) {
    return x.depth != y.depth ? x.depth > y.depth : x.feature < y.feature;
  });
  std::pmr::vector<Points> patches(&memory_);
  for (const Place& place : order) {
    meter_.spend(1 + static_cast<int>(patches.size() / 16));
    const Contact& c = all_[place.at];
    const auto same = std::find_if(patches.begin(), patches.end(),
                                   [&](const Points& p) { return p.front().normal.dot(c.normal) > one_patch; });
    (same == patches.end() ? patches.emplace_back() : *same).push_back(c);
  }
  if (solid) {
    std::pmr::vector<std::uint8_t> far(patches.size(), 0, &memory_);
    const auto behind = [&](const Contact& c) { return c.normal.dot(centre - c.point) < 0; };
    for (std::size_t i = 0; i < patches.size(); ++i)
      for (const auto& other : patches)
        if (patches[i].front().normal.dot(other.front().normal) < opposing && behind(patches[i].front()) &&
            !behind(other.front()))
          far[i] = 1;
    std::size_t i = 0;
    std::erase_if(patches, [&](const auto&) { return far[i++] != 0; });
  }
  // Of a sheet that lies on the surface rounding says which side it is on: one patch.
  const double slack = tolerance::alike * size_;
  const auto only_touches = [&](const Points& patch) {
    return std::all_of(patch.begin(), patch.end(), [&](const Contact& c) { return std::abs(c.depth) <= slack; });
  };
  for (std::size_t i = 0; i < patches.size(); ++i)
    for (std::size_t j = i + 1; j < patches.size(); ++j) {
      const Contact &own = patches[i].front(), &other = patches[j].front();
      if (own.normal.dot(other.normal) > one_side || std::abs(own.normal.dot(other.point - own.point)) > slack)
        continue;
      if (!only_touches(patches[i]) || !only_touches(patches[j])) continue;
      for (Contact& c : patches[j]) {
        c.normal = -c.normal;
        patches[i].push_back(c);
      }
      patches.erase(patches.begin() + static_cast<std::ptrdiff_t>(j--));
    }
  const std::size_t first = out.size();
  for (const Points& patch : patches) {
    const std::size_t own = out.size();
    out.insert(out.end(), patch.begin(), patch.end());
    keep_widest(out, own, size_);
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
            [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
}

}  // namespace tandem
