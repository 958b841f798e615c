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

/// Chooses at most four of a patch's contacts that span it, the deepest among them.
class WidestPoints {
 public:
  WidestPoints(std::span<Contact> contacts, double size)
      : p_(contacts), slack_(tolerance::alike * size), axis_(contacts[0].normal), tie_break_(uncommon(axis_)) {}

  /// Corners of the patch: along a direction, far from that, off their line, outside of their triangle.
  void span();
  /// The deepest one is kept, or one that counts as deep has its depth.
  void keep_deepest();
  /// Those kept, to the front of the contacts.
  std::size_t move_to_front();

 private:
  template <class Score>
  std::size_t best(Score&& score);
  std::size_t farthest_outside(std::size_t third, const Vec3& side);
  void replace_nearest(std::size_t deepest);

  std::span<Contact> p_;
  double slack_;
  Vec3 axis_, tie_break_;
  double most_ = 0;  // the score of the last best
  std::array<std::size_t, 4> kept_{};
  std::size_t count_ = 0;
};

/// Of those that are as good as the best but for rounding the one farthest along a direction of its own: where they are
/// in the list may be rounding's doing, too.
template <class Score>
std::size_t WidestPoints::best(Score&& score) {
  most_ = score(p_[0]);
  for (const Contact& c : p_) most_ = std::max(most_, score(c));
  std::size_t winner = p_.size();
  for (std::size_t i = 0; i < p_.size(); ++i)
    if (score(p_[i]) >= most_ - slack_ &&
        (winner == p_.size() || tie_break_.dot(p_[i].point) > tie_break_.dot(p_[winner].point)))
      winner = i;
  return winner;
}

void WidestPoints::span() {
  // What is told apart by less could be one of those kept before: the best but for rounding is less by up to `slack_`.
  const double apart = 2 * slack_;
  kept_[count_++] = best([&](const Contact& c) { return tie_break_.dot(c.point); });
  const Vec3 from = p_[kept_[0]].point;
  const std::size_t second = best([&](const Contact& c) { return (c.point - from).norm(); });
  const double length = most_;
  if (!(length > apart)) return;
  kept_[count_++] = second;
  const Vec3 along = (p_[second].point - from) / length, side = axis_.cross(along);
  const std::size_t third = best([&](const Contact& c) { return std::abs(side.dot(c.point - from)); });
  if (!(most_ > std::max(thin * length, apart))) return;
  kept_[count_++] = third;
  const std::size_t fourth = farthest_outside(third, side);
  if (most_ > std::max(thin * length, apart)) kept_[count_++] = fourth;
}

/// Of the triangle of the first three.
std::size_t WidestPoints::farthest_outside(std::size_t third, const Vec3& side) {
  const double turn = side.dot(p_[third].point - p_[kept_[0]].point) >= 0 ? 1.0 : -1.0;
  std::array<Vec3, 3> outward;
  for (std::size_t k = 0; k < 3; ++k)
    outward[k] = -turn * axis_.cross(p_[kept_[(k + 1) % 3]].point - p_[kept_[k]].point).stableNormalized();
  return best([&](const Contact& c) {
    double out = 0;
    for (std::size_t k = 0; k < 3; ++k) out = std::max(out, outward[k].dot(c.point - p_[kept_[k]].point));
    return out;
  });
}

void WidestPoints::keep_deepest() {
  const std::size_t deepest = best([](const Contact& c) { return c.depth; });
  const auto deepest_kept = std::max_element(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(count_),
                                             [&](std::size_t i, std::size_t j) { return p_[i].depth < p_[j].depth; });
  if (p_[*deepest_kept].depth >= most_ - slack_) {
    p_[*deepest_kept].depth = most_;
    return;
  }
  p_[deepest].depth = most_;
  if (count_ < kept_.size())
    kept_[count_++] = deepest;
  else
    replace_nearest(deepest);
}

void WidestPoints::replace_nearest(std::size_t deepest) {
  const auto away = [&](std::size_t i) { return (p_[i].point - p_[deepest].point).norm(); };
  const double nearest = away(
      *std::min_element(kept_.begin(), kept_.end(), [&](std::size_t i, std::size_t j) { return away(i) < away(j); }));
  std::size_t* least = nullptr;
  for (std::size_t& i : kept_)
    if (away(i) <= nearest + slack_ && (!least || tie_break_.dot(p_[i].point) < tie_break_.dot(p_[*least].point)))
      least = &i;
  *least = deepest;
}

std::size_t WidestPoints::move_to_front() {
  std::array<Contact, 4> widest;  // some of them may stand where others go
  for (std::size_t k = 0; k < count_; ++k) widest[k] = p_[kept_[k]];
  std::copy_n(widest.begin(), count_, p_.begin());
  std::sort(p_.begin(), p_.begin() + static_cast<std::ptrdiff_t>(count_),
            [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
  return count_;
}

}  // namespace

Vec3 uncommon(const Vec3& axis) {
  const Vec3 across = axis.cross(Vec3(0.3613, 0.4789, 0.8001));
  return across.squaredNorm() > 0.1 ? across : axis.cross(Vec3(0.8171, -0.5471, 0.1829));
}

void keep_widest(std::vector<Contact>& contacts, std::size_t first, double size) {
  if (contacts.size() <= first + 1) return;
  WidestPoints widest(std::span<Contact>(contacts).subspan(first), size);
  widest.span();
  widest.keep_deepest();
  contacts.resize(first + widest.move_to_front());
}

void PatchCollector::add(std::uint32_t t, std::span<const Contact> contacts, double deepest) {
  std::uint32_t k = 0;
  for (const Contact& c : contacts) {
    if (c.depth > deepest) continue;
    all_.push_back(c);
    all_.back().feature = t * 64 + k++;
  }
}

namespace {

// Of each patch the points that span it, in the order of their features.
template <class Patches>
void append_widest(const Patches& patches, double size, WorkMeter& meter, std::vector<Contact>& out) {
  const std::size_t first = out.size();
  for (const auto& patch : patches) {
    const std::size_t own = out.size();
    meter.spend(1 + static_cast<int>(patch.size() / 2));
    out.insert(out.end(), patch.begin(), patch.end());
    keep_widest(out, own, size);
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
            [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
}

}  // namespace

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
  const int pass = 1 + static_cast<int>(patches.size() / 16);
  if (solid) {
    std::pmr::vector<std::uint8_t> far(patches.size(), 0, &memory_);
    const auto behind = [&](const Contact& c) { return c.normal.dot(centre - c.point) < 0; };
    for (std::size_t i = 0; i < patches.size(); ++i) {
      meter_.spend(pass);
      for (const auto& other : patches)
        if (patches[i].front().normal.dot(other.front().normal) < opposing && behind(patches[i].front()) &&
            !behind(other.front()))
          far[i] = 1;
    }
    std::size_t i = 0;
    std::erase_if(patches, [&](const auto&) { return far[i++] != 0; });
  }
  // Of a sheet that lies on the surface rounding says which side it is on: one patch.
  const double slack = tolerance::alike * size_;
  const auto only_touches = [&](const Points& patch) {
    return std::all_of(patch.begin(), patch.end(), [&](const Contact& c) { return std::abs(c.depth) <= slack; });
  };
  for (std::size_t i = 0; i < patches.size(); ++i) {
    meter_.spend(pass);
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
  }
  append_widest(patches, size_, meter_, out);
}

}  // namespace tandem
