// Groups the contacts of a mesh with a convex shape into patches of at most four points.
#include "manifold/patch_collector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "manifold/manifold.h"
#include "shapes/metered_sort.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// Cosine between the normals of two patches below which they push against each other (135 degrees).
constexpr double opposing = -0.7;
/// Cosine between the normals of two patches up to which they may be the two sides of one surface (179.2 degrees).
constexpr double two_sides = -0.9999;

/// Chooses at most four of a patch's contacts that span it, the deepest among them.
class WidestPoints {
 public:
  WidestPoints(std::span<Contact> contacts, double size, WorkMeter* meter)
      : p_(contacts),
        slack_(tolerance::alike * size),
        axis_(contacts[0].normal),
        tie_break_(tie_break_direction(axis_)),
        meter_(meter) {}

  /// Chooses corners of the patch: along a direction, far from that one, off their line, outside of their triangle.
  void span();
  /// Makes sure that the deepest contact is kept, or that one that counts as equally deep has its depth.
  void keep_deepest();
  /// Moves the chosen contacts to the front; returns how many.
  std::size_t move_to_front();

 private:
  template <class Score>
  std::size_t best(Score&& score);
  std::size_t farthest_outside(std::size_t third, const Vec3& side);
  void replace_nearest(std::size_t deepest);

  std::span<Contact> p_;
  double slack_;
  Vec3 axis_, tie_break_;
  WorkMeter* meter_;
  double most_ = 0;  // the last best score
  std::array<std::size_t, 4> kept_{};
  std::size_t count_ = 0;
};

/// Among those equal to the best to rounding, the one farthest along a direction of its own: the order in the list may
/// depend on rounding, too.
template <class Score>
std::size_t WidestPoints::best(Score&& score) {
  constexpr std::size_t at_once = 64;
  const auto count = [&](std::size_t i) {
    if (i % at_once == 0 && meter_ != nullptr) meter_->spend(4);
  };
  most_ = score(p_[0]);
  std::size_t first = 0;  // those before it are not equal to the best
  for (std::size_t i = 0; i < p_.size(); ++i) {
    count(i);
    const double own = score(p_[i]);
    if (own > most_ + 2 * slack_) first = i;
    most_ = std::max(most_, own);
  }
  std::size_t winner = p_.size();
  for (std::size_t i = first; i < p_.size(); ++i) {
    count(i);
    if (score(p_[i]) >= most_ - slack_ &&
        (winner == p_.size() || tie_break_.dot(p_[i].point) > tie_break_.dot(p_[winner].point)))
      winner = i;
  }
  return winner;
}

void WidestPoints::span() {
  // A point closer than this to a chosen one could be the same: scores equal to rounding differ by up to `slack_`.
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

/// Outside the triangle of the first three.
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
  std::array<Contact, 4> widest;  // a copy, since some of them may be overwritten
  for (std::size_t k = 0; k < count_; ++k) widest[k] = p_[kept_[k]];
  std::copy_n(widest.begin(), count_, p_.begin());
  std::sort(p_.begin(), p_.begin() + static_cast<std::ptrdiff_t>(count_),
            [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
  return count_;
}

}  // namespace

Vec3 tie_break_direction(const Vec3& axis) {
  const Vec3 across = axis.cross(Vec3(0.3613, 0.4789, 0.8001));
  return across.squaredNorm() > 0.1 ? across : axis.cross(Vec3(0.8171, -0.5471, 0.1829));
}

void keep_widest(std::vector<Contact>& contacts, std::size_t first, double size, WorkMeter* meter) {
  if (contacts.size() <= first + 1) return;
  WidestPoints widest(std::span<Contact>(contacts).subspan(first), size, meter);
  widest.span();
  widest.keep_deepest();
  contacts.resize(first + widest.move_to_front());
}

void PatchCollector::add(std::uint32_t t, std::span<const Contact> contacts) {
  const std::size_t first = runs_.size();
  for (const Contact& c : contacts) {
    if (runs_.size() == first || runs_.back().normal != c.normal)
      runs_.push_back({c.normal, t, static_cast<std::uint32_t>(points_.size()), runs_.size() > first});
    points_.push_back({c.point, c.depth});
  }
}

/// A contact in the order in which patches are found: deeper ones first; of equals (to rounding; none are nearer to
/// touching than these) the one whose triangle comes first.
struct PatchCollector::Place {
  double depth;  // in units within which depths count as equal, an integer
  std::uint32_t feature, point, run;

  bool operator<(const Place& other) const {
    if (depth != other.depth) return depth > other.depth;
    return feature != other.feature ? feature < other.feature : point < other.point;
  }
};

struct PatchCollector::Patch {
  Vec3 normal;
  Place deepest;
  std::uint32_t first = 0, count = 0;  // places
  std::uint32_t side_of = 0;           // the patch of which it is the opposite side, else itself
};

PatchCollector::List<PatchCollector::Place> PatchCollector::places_of(double deepest) {
  List<Place> places(&memory_);
  places.reserve(points_.size());
  std::uint32_t of_triangle = 0;
  for (std::uint32_t r = 0; r < runs_.size(); ++r) {
    const std::size_t end = r + 1 < runs_.size() ? runs_[r + 1].first : points_.size();
    if (!runs_[r].goes_on) of_triangle = 0;
    meter_.spend();
    for (std::uint32_t i = runs_[r].first; i < end; ++i)
      if (const double depth = points_[i].depth; depth <= deepest)
        places.push_back({std::round(depth / (tolerance::same_depth * size_)),
                          runs_[r].triangle * contacts_of_one + std::min(of_triangle++, contacts_of_one - 1), i, r});
  }
  return places;
}

// The deepest contact of each run looks for a patch with about its normal; where there is none, it begins one.
PatchCollector::List<PatchCollector::Patch> PatchCollector::find_patches(const List<Place>& places) {
  List<Place> runs(&memory_);  // the deepest place of each run
  runs.reserve(runs_.size());
  for (const Place& place : places)
    if (runs.empty() || runs.back().run != place.run)
      runs.push_back(place);
    else
      runs.back() = std::min(runs.back(), place);
  sort_metered(meter_, runs.begin(), runs.end(), std::less<Place>());
  List<Patch> patches(&memory_);
  for (const Place& run : runs) {
    meter_.spend(1 + static_cast<int>(patches.size() / 16));
    const Vec3& n = runs_[run.run].normal;
    const auto is_same = [&](const Patch& patch) { return patch.normal.dot(n) > one_patch; };
    const auto own =
        static_cast<std::uint32_t>(std::find_if(patches.begin(), patches.end(), is_same) - patches.begin());
    if (own == patches.size()) patches.push_back({.normal = n, .deepest = run, .side_of = own});
    runs_[run.run].patch = own;
  }
  return patches;
}

PatchCollector::List<PatchCollector::Place> PatchCollector::by_patch(const List<Place>& places, List<Patch>& patches) {
  for (const Place& place : places) ++patches[runs_[place.run].patch].count;
  std::uint32_t first = 0;
  for (Patch& patch : patches) patch.first = first, first += std::exchange(patch.count, 0);
  List<Place> ordered(places.size(), &memory_);
  for (const Place& place : places) {
    Patch& patch = patches[runs_[place.run].patch];
    ordered[patch.first + patch.count++] = place;
  }
  for (const Patch& patch : patches) {
    meter_.spend(1 + static_cast<int>(std::min(patch.count, 512u) / 4));
    const auto begin = ordered.begin() + patch.first;
    sort_metered(meter_, begin, begin + patch.count, std::less<Place>());
  }
  return ordered;
}

void PatchCollector::leave_out_far(const Vec3& centre, List<Patch>& patches) {
  const auto behind = [&](const Patch& p) { return p.normal.dot(centre - points_[p.deepest.point].at) < 0; };
  const auto is_far = [&](const Patch& patch) {
    meter_.spend(1 + static_cast<int>(patches.size() / 16));
    return behind(patch) && std::any_of(patches.begin(), patches.end(), [&](const Patch& other) {
             return patch.normal.dot(other.normal) < opposing && !behind(other);
           });
  };
  List<std::uint8_t> far(&memory_);
  for (const Patch& patch : patches) far.push_back(is_far(patch) ? 1 : 0);
  for (std::size_t i = 0; i < patches.size(); ++i)
    if (far[i] != 0) patches[i].count = 0;
}

// Joins the two sides of an open surface on which the shape rests: which side a contact is on depends on rounding.
void PatchCollector::join_sides(const List<Place>& places, List<Patch>& patches) {
  const double slack = tolerance::alike * size_;
  const auto only_touches = [&](const Patch& patch) {
    return std::all_of(places.begin() + patch.first, places.begin() + patch.first + patch.count,
                       [&](const Place& place) { return std::abs(points_[place.point].depth) <= slack; });
  };
  const auto is_free = [&](std::uint32_t i) { return patches[i].count > 0 && patches[i].side_of == i; };
  for (std::uint32_t i = 0; i < patches.size(); ++i) {
    meter_.spend(1 + static_cast<int>(patches.size() / 16));
    if (!is_free(i)) continue;
    const Vec3 &normal = patches[i].normal, &at = points_[patches[i].deepest.point].at;
    for (std::uint32_t j = i + 1; j < patches.size(); ++j) {
      if (normal.dot(patches[j].normal) > two_sides || !is_free(j)) continue;
      if (std::abs(normal.dot(points_[patches[j].deepest.point].at - at)) > slack) continue;
      if (only_touches(patches[i]) && only_touches(patches[j])) patches[j].side_of = i;
    }
  }
}

// Appends the points that span each patch, in the order of their features.
void PatchCollector::append_widest(const List<Place>& places, const List<Patch>& patches, std::vector<Contact>& out) {
  const std::size_t first = out.size();
  for (std::uint32_t i = 0; i < patches.size(); ++i) {
    if (patches[i].side_of != i) continue;
    const std::size_t own = out.size();
    for (std::uint32_t j = i; j < patches.size(); ++j) {
      const Patch& side = patches[j];
      if (side.side_of != i) continue;
      for (std::uint32_t k = side.first; k < side.first + side.count; ++k) {
        const Vec3& normal = runs_[places[k].run].normal;
        const Point& point = points_[places[k].point];
        out.push_back({point.at, j == i ? normal : Vec3(-normal), point.depth, places[k].feature});
      }
    }
    meter_.spend();
    keep_widest(out, own, size_, &meter_);
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
            [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
}

void PatchCollector::finish(const Vec3& centre, bool solid, std::vector<Contact>& out, double deepest) {
  const List<Place> places = places_of(deepest);
  List<Patch> patches = find_patches(places);
  const List<Place> ordered = by_patch(places, patches);
  if (solid) leave_out_far(centre, patches);
  join_sides(ordered, patches);
  append_widest(ordered, patches, out);
}

}  // namespace tandem
