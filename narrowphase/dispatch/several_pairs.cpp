// Several pairs at once: groups of pairs that are solved a pair a lane.
#include "tandem/narrowphase/several_pairs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>

#include "boxes/box_manifold.h"
#include "boxes/box_screen.h"
#include "boxes/halfspace_boxes.h"
#include "dispatch/sphere_lanes.h"
#include "manifold/manifold.h"
#include "pairs/convex_pair.h"
#include "pairs/solver_table.h"
#include "shapes/pair_order.h"
#include "shapes/undecided.h"
#include "tolerances.h"

namespace tandem {
namespace {

LaneGroup group_of(const PlacedPair& pair, const PlacedSpheres& spheres) {
  if (spheres.a != nullptr && spheres.b != nullptr) return LaneGroup::spheres;
  if (pair.a->rounding() + pair.b->rounding() > 0) return LaneGroup::none;
  return pair_solver(pair.a->kind(), pair.b->kind()).lanes;
}

bool is_undecided(const PlacedPair& pair, double distance) {
  return std::abs(distance) <= undecided_distance(*pair.a, *pair.pose_a, *pair.b, *pair.pose_b);
}

/// Pairs of boxes, in consecutive columns.
class BoxesOfPairs {
 public:
  static constexpr std::size_t most = BoxPairRows::most;

  /// Takes the pairs that the quick test does not separate; returns their bits. There must be room for a whole list.
  std::uint32_t take(const BoxPairList& pairs, double margin) {
    const std::uint32_t near = take_near_boxes(pairs, margin, rows_, count_);
    count_ += static_cast<std::size_t>(std::popcount(near));
    return near;
  }
  void screen(double margin) {
    if (count_ == 0) return;
    overlap_boxes(rows_, count_, margin, found_);
    std::size_t patches = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      clipped_[patches] = static_cast<std::int64_t>(k);
      patches += found_.finding[k] == BoxFinding::faces ? 1 : 0;
    }
    std::fill_n(clipped_ + patches, columns_beyond, std::int64_t{0});
    clip_rectangles(found_.faces, clipped_, patches, margin, patches_);
    count_ = next_ = next_patch_ = 0;
  }
  /// Appends the next pair's answer; false if it must be solved separately.
  bool answer(const PlacedPair& pair, std::size_t number, double margin, std::vector<Contact>& contacts,
              AnswerSink& answers) {
    const std::size_t k = next_++, first = contacts.size();
    const std::int64_t finding = found_.finding[k];
    // Solved separately if rounding decides whether they touch.
    const bool undecided = is_undecided(pair, found_.distance[k]);
    if (finding == BoxFinding::apart && !undecided) return true;
    if (finding == BoxFinding::unknown || undecided) {
      if (finding == BoxFinding::faces) ++next_patch_;
      return false;
    }
    PairAnswer& answer = answers.begin(number);
    if (finding == BoxFinding::faces) {
      const std::size_t patch = next_patch_++;
      if (append_patch(pair, k, patch, contacts, answer)) {
        answers.end();
        return true;
      }
    }
    if (finding == BoxFinding::point) {
      answer.collide = true;
      found_.answers.copy(k, found_.contacts, answer);
      found_.contacts.copy(k, contacts.emplace_back());
    } else if (rows_.sense[k] < 0) {
      append_boxes(pair.b->parameters(), *pair.pose_b, pair.a->parameters(), *pair.pose_a, found_.answer(k), margin,
                   contacts, answer);
      swap_answer(answer, &contacts, first);
    } else {
      append_boxes(pair.a->parameters(), *pair.pose_a, pair.b->parameters(), *pair.pose_b, found_.answer(k), margin,
                   contacts, answer);
    }
    answers.end();
    return true;
  }

 private:
  bool append_patch(const PlacedPair& pair, std::size_t k, std::size_t patch, std::vector<Contact>& contacts,
                    PairAnswer& answer) const {
    const std::size_t first = contacts.size();
    const bool reversed = rows_.sense[k] < 0, tilted = found_.axis[k] >= 6 && found_.facing[k] <= tolerance::flush_face;
    const Shape &a = reversed ? *pair.b : *pair.a, &b = reversed ? *pair.a : *pair.b;
    const Pose &pose_a = reversed ? *pair.pose_b : *pair.pose_a, &pose_b = reversed ? *pair.pose_a : *pair.pose_b;
    append_box_patch(found_.faces, k, patches_, patch, tilted, a.parameters(), pose_a, b.parameters(), pose_b,
                     found_.contacts.normal(k), contacts);
    if (contacts.size() == first) return false;
    if (tilted) {
      answer.collide = true;
      found_.answers.copy(k, found_.contacts, answer);
    } else {
      answer_by_deepest(std::span(contacts).subspan(first), found_.distance[k], answer);
    }
    return true;
  }

  std::size_t count_ = 0, next_ = 0, next_patch_ = 0;
  BoxPairRows rows_;
  BoxFindingRows found_;
  std::int64_t clipped_[most + columns_beyond];  // columns of rows
  RectanglePatchRows patches_;
};

/// The half-spaces of pairs, in the world.
class PlacedHalfspaces {
 public:
  static constexpr std::size_t most = HalfspaceBoxList::most;

  /// The half-space of a pair, which is its second shape if reversed.
  const PlacedHalfspace& place(const PlacedPair& pair, bool reversed) {
    const Shape& halfspace = reversed ? *pair.b : *pair.a;
    const Pose& at = reversed ? *pair.pose_b : *pair.pose_a;
    // Most pairs have the same one.
    if (count_ == 0 || &halfspace != last_.shape || &at != last_.pose || reversed != last_.reversed) {
      placed_[count_++] = {at.rotation * halfspace.normal(), halfspace.offset(), at.translation, reversed ? -1.0 : 1.0};
      last_ = {&halfspace, &at, reversed};
    }
    return placed_[count_ - 1];
  }
  void clear() { count_ = 0; }

 private:
  struct Source {
    const Shape* shape;
    const Pose* pose;
    bool reversed;
  };

  std::size_t count_ = 0;
  PlacedHalfspace placed_[most];
  Source last_;  // of the last one placed
};

/// Pairs of a half-space and a box.
class HalfspaceBoxes {
 public:
  static constexpr std::size_t most = HalfspaceBoxList::most;

  void add(const PlacedPair& pair, PlacedHalfspaces& halfspaces) {
    const bool reversed = pair.a->kind() == ShapeKind::box;
    list_.halfspace[list_.count] = &halfspaces.place(pair, reversed);
    list_.pose[list_.count] = reversed ? pair.pose_a : pair.pose_b;
    list_.half[list_.count++] = &(reversed ? *pair.a : *pair.b).parameters();
  }
  void screen(double margin) {
    if (list_.count == 0) return;
    find_on_halfspaces(list_, margin, found_);
    list_.count = next_ = 0;
  }
  bool answer(const PlacedPair& pair, std::size_t number, double margin, std::vector<Contact>& contacts,
              AnswerSink& answers) {
    const std::size_t k = next_++;
    if (!found_.known[k] || is_undecided(pair, found_.distance[k])) return false;
    if (found_.distance[k] > margin) return true;
    if (found_.corners[k] == 0) return false;  // rounding may remove the only corner that just touches
    PairAnswer& answer = answers.begin(number);
    answer.collide = found_.distance[k] <= 0;
    found_.answers.copy(k, found_.contacts[0], answer);
    // All four are written, and those that do not touch are overwritten: which do is unpredictable.
    std::size_t end = contacts.size();
    contacts.resize(end + 4);
    for (std::size_t i = 0; i < 4; ++i) {
      found_.contacts[i].copy(k, contacts[end]);
      end += found_.corners[k] >> i & 1u;
    }
    contacts.resize(end);
    answers.end();
    return true;
  }

 private:
  std::size_t next_ = 0;
  HalfspaceBoxList list_;
  HalfspaceBoxFindings found_;
};

PlacedSphere sphere_of(const PlacedSphere* placed, const Shape& sphere, const Pose& pose) {
  return placed != nullptr ? *placed : PlacedSphere{pose.translation, sphere.radius()};
}

/// Pairs of a sphere and another shape, and the kernel that solves them.
template <class Pair, void (*find)(std::span<const Pair>, double margin, SphereFindings&)>
class SpherePairs {
 public:
  static constexpr std::size_t most = SphereFindings::most;

  void add(const Pair& pair) { pairs_[count_++] = pair; }
  void screen(double margin) {
    if (count_ == 0) return;
    find(std::span(pairs_).first(count_), margin, found_);
    count_ = next_ = 0;
  }
  bool answer(std::size_t number, std::vector<Contact>& contacts, AnswerSink& answers) {
    return found_.append(next_++, number, contacts, answers);
  }

 private:
  std::size_t count_ = 0, next_ = 0;
  std::array<Pair, most> pairs_;
  SphereFindings found_;
};

/// Groups pairs by their kernels, until they are answered in order.
class PairGroups {
 public:
  static constexpr std::size_t block = 32;

  /// Takes some pairs, at most a block, starting with number `first`.
  void take(std::span<const PlacedPair> pairs, std::span<const PlacedSpheres> spheres, std::size_t first, bool by_kind,
            double margin) {
    std::array<LaneGroup, block> kinds;
    std::array<std::uint8_t, block> place;
    BoxPairList boxes;
    std::uint32_t left = 0;  // bits of those that must be answered
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      kinds[i] = by_kind ? group_of(pairs[i], spheres.empty() ? PlacedSpheres{} : spheres[i]) : LaneGroup::none;
      if (kinds[i] == LaneGroup::boxes) {
        place[boxes.count] = static_cast<std::uint8_t>(i);
        boxes.add(pairs[i]);
      } else {
        left |= std::uint32_t{1} << i;
      }
    }
    if (boxes.count != 0)
      for (std::uint32_t near = boxes_.take(boxes, margin); near != 0; near &= near - 1)
        left |= std::uint32_t{1} << place[static_cast<std::size_t>(std::countr_zero(near))];
    for (; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      add(pairs[i], spheres.empty() ? PlacedSpheres{} : spheres[i], kinds[i]);
      waiting_[count_++] = {static_cast<std::uint32_t>(first + i), kinds[i]};
    }
  }
  bool has_space() const { return count_ + block <= most; }

  /// Answers all waiting pairs; those of no group by `alone(pair's number)`.
  template <class Alone>
  void answer(std::span<const PlacedPair> pairs, double margin, std::vector<Contact>& contacts, AnswerSink& answers,
              const Alone& alone) {
    boxes_.screen(margin);
    spheres_.screen(margin);
    halfspace_boxes_.screen(margin);
    halfspace_spheres_.screen(margin);
    halfspaces_.clear();
    for (const auto& [i, kind] : std::span(waiting_).first(count_))
      if (!answer_together(pairs[i], i, kind, margin, contacts, answers)) alone(i);
    count_ = 0;
  }

 private:
  static constexpr std::size_t most = 3 * block;
  static_assert(most <= BoxesOfPairs::most && most <= HalfspaceBoxes::most && most <= SphereFindings::most);

  struct Waiting {
    std::uint32_t pair;
    LaneGroup kind;
  };

  /// Boxes with boxes are taken before.
  void add(const PlacedPair& pair, const PlacedSpheres& placed, LaneGroup kind) {
    const auto a = [&] { return sphere_of(placed.a, *pair.a, *pair.pose_a); };
    const auto b = [&] { return sphere_of(placed.b, *pair.b, *pair.pose_b); };
    if (kind == LaneGroup::spheres) spheres_.add({a(), b()});
    if (kind == LaneGroup::halfspace_box) halfspace_boxes_.add(pair, halfspaces_);
    if (kind == LaneGroup::halfspace_sphere) {
      const bool reversed = pair.a->kind() == ShapeKind::sphere;
      halfspace_spheres_.add({&halfspaces_.place(pair, reversed), reversed ? a() : b()});
    }
  }

  bool answer_together(const PlacedPair& pair, std::size_t number, LaneGroup kind, double margin,
                       std::vector<Contact>& contacts, AnswerSink& answers) {
    switch (kind) {
      case LaneGroup::spheres:
        return spheres_.answer(number, contacts, answers);
      case LaneGroup::halfspace_sphere:
        return halfspace_spheres_.answer(number, contacts, answers);
      case LaneGroup::boxes:
        return boxes_.answer(pair, number, margin, contacts, answers);
      case LaneGroup::halfspace_box:
        return halfspace_boxes_.answer(pair, number, margin, contacts, answers);
      case LaneGroup::none:
        break;
    }
    return false;
  }

  std::array<Waiting, most> waiting_;
  std::size_t count_ = 0;
  BoxesOfPairs boxes_;
  PlacedHalfspaces halfspaces_;
  HalfspaceBoxes halfspace_boxes_;
  SpherePairs<SpherePair, find_on_spheres> spheres_;
  SpherePairs<HalfspaceSphere, find_spheres_on_halfspaces> halfspace_spheres_;
};

}  // namespace

std::uint32_t SeveralPairs::near(std::span<const PlacedSpheres> pairs) const { return near_spheres(pairs, margin_); }

SpheresSolved SeveralPairs::solve_spheres(std::span<const PlacedSpheres> pairs, const AnswerPlaces& to) const {
  return by_kind_ ? tandem::solve_spheres(pairs, margin_, to) : SpheresSolved{};
}

void SeveralPairs::solve(std::span<const PlacedPair> pairs, std::vector<Contact>& contacts, AnswerSink& answers,
                         std::span<const PlacedSpheres> spheres) const {
  if (!spheres.empty() && spheres.size() != pairs.size())
    throw std::invalid_argument("SeveralPairs: spheres of " + std::to_string(spheres.size()) + " pairs, allowed: of " +
                                std::to_string(pairs.size()) + ", or none");
  PairGroups groups;
  const auto answer_waiting = [&] {
    groups.answer(pairs, margin_, contacts, answers, [&](std::size_t i) {
      const PlacedPair& pair = pairs[i];
      PairAnswer& answer = answers.begin(i);
      answer = one_by_one_.solve(*pair.a, *pair.pose_a, *pair.b, *pair.pose_b, Request::contacts, &contacts);
      answers.end();
    });
  };
  constexpr std::size_t block = PairGroups::block;
  for (std::size_t first = 0; first < pairs.size(); first += block) {
    const std::size_t count = std::min(block, pairs.size() - first);
    groups.take(pairs.subspan(first, count), spheres.empty() ? spheres : spheres.subspan(first, count), first, by_kind_,
                margin_);
    if (!groups.has_space()) answer_waiting();
  }
  answer_waiting();
}

}  // namespace tandem
