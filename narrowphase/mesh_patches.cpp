#include "mesh_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tandem {
namespace {

constexpr double one_patch = 0.9;  // cosine of the angle between normals
constexpr double opposing = -0.7;
constexpr double same_point = 1e-9;     // of the size
constexpr double worth_keeping = 1e-6;  // of the size: a point this much deeper than the corners of its patch
constexpr double thin = 0.005;          // width of a patch to its length: an edge

using Points = std::pmr::vector<Contact>;

// Appends at most four of the points, wherever they came from: the extremes of the patch, and the deepest if it is none
// of them. Equal depths are equal but for rounding, so none of them leads.
void append_widest(const Points& p, double size, std::vector<Contact>& out) {
  if (p.size() <= 1) {
    out.insert(out.end(), p.begin(), p.end());
    return;
  }
  const Vec3 axis = p.front().normal;
  const Vec3 start = axis.cross(Vec3(0.36, 0.48, 0.8));
  const auto best = [&](auto&& score) {
    std::size_t winner = 0;
    double most = score(p[0]);
    for (std::size_t i = 1; i < p.size(); ++i)
      if (const double s = score(p[i]); s > most + 1e-9 * size) winner = i, most = s;
    return winner;
  };
  std::array<std::size_t, 4> kept;
  kept.fill(p.size());  // none
  kept[0] = best([&](const Contact& c) { return start.dot(c.point); });
  const Vec3 from = p[kept[0]].point;
  std::size_t count = 1;
  kept[count++] = best([&](const Contact& c) { return (c.point - from).norm(); });
  const Vec3 along = p[kept[1]].point - from;
  const double length = along.norm();
  if (length > same_point * size) {
    const Vec3 side = axis.cross(along).normalized();
    for (const double s : {1.0, -1.0}) {
      const std::size_t k = best([&](const Contact& c) { return s * side.dot(c.point - from); });
      if (s * side.dot(p[k].point - from) > thin * length) kept[count++] = k;
    }
  } else {
    kept[--count] = p.size();
  }
  const std::size_t deepest = best([](const Contact& c) { return c.depth; });
  double most = p[kept[0]].depth;
  for (const std::size_t k : std::span(kept).first(count)) most = std::max(most, p[k].depth);
  if (p[deepest].depth > most + worth_keeping * size) {
    if (count < kept.size()) {
      kept[count++] = deepest;
    } else {
      // It stands for the one nearest to it.
      *std::min_element(kept.begin(), kept.end(), [&](std::size_t i, std::size_t j) {
        return (p[i].point - p[deepest].point).squaredNorm() < (p[j].point - p[deepest].point).squaredNorm();
      }) = deepest;
    }
  }
  std::sort(kept.begin(), kept.end());
  for (std::size_t k = 0; k < count; ++k)
    if (k == 0 || kept[k] != kept[k - 1]) out.push_back(p[kept[k]]);
}

}  // namespace

void PatchCollector::add(std::uint32_t t, std::span<const Contact> contacts) {
  for (std::uint32_t k = 0; k < contacts.size(); ++k) {
    Contact c = contacts[k];
    c.feature = t * 4 + std::min(k, 3u);
    all_.push_back(c);
  }
}

void PatchCollector::finish(const Vec3& centre, bool solid, std::vector<Contact>& out) {
  // Deeper ones found patches; of equals (to rounding) the one whose triangle comes first.
  struct Place {
    double depth;
    std::uint32_t feature, at;
  };
  std::pmr::vector<Place> order(&memory_);
  order.reserve(all_.size());
  for (std::uint32_t i = 0; i < all_.size(); ++i)
    order.push_back({std::floor(all_[i].depth / (worth_keeping * size_)), all_[i].feature, i});
  std::sort(order.begin(), order.end(), [](const Place& x, const Place& y) {
    return x.depth != y.depth ? x.depth > y.depth : x.feature < y.feature;
  });
  std::pmr::vector<Points> patches(&memory_);
  for (const Place& place : order) {
    const Contact& c = all_[place.at];
    const auto same = std::find_if(patches.begin(), patches.end(),
                                   [&](const Points& p) { return p.front().normal.dot(c.normal) > one_patch; });
    if (same == patches.end()) {
      patches.emplace_back().push_back(c);
      continue;
    }
    // A point on an edge belongs to the triangles of both sides.
    const auto twin = std::find_if(same->begin(), same->end(),
                                   [&](const Contact& o) { return (o.point - c.point).norm() <= same_point * size_; });
    if (twin == same->end()) same->push_back(c);
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
  const std::size_t first = out.size();
  for (const Points& patch : patches) append_widest(patch, size_, out);
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
            [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
}

}  // namespace tandem
