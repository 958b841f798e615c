#include "tandem/narrowphase/several_pairs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "boxes/box_manifold.h"
#include "boxes/box_screen.h"
#include "boxes/halfspace_boxes.h"
#include "dispatch/undecided.h"
#include "manifold/manifold.h"
#include "pairs/convex_pair.h"
#include "pairs/simple_pairs.h"
#include "shapes/pair_order.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// The kinds of pairs that are solved together.
enum class Together : std::uint8_t { none, boxes, halfspace_box };

Together together(const PlacedPair& pair) {
  const ShapeKind a = pair.a->kind(), b = pair.b->kind();
  if (pair.a->rounding() + pair.b->rounding() > 0) return Together::none;
  if (a == ShapeKind::box && b == ShapeKind::box) return Together::boxes;
  const bool one =
      (a == ShapeKind::box && b == ShapeKind::halfspace) || (a == ShapeKind::halfspace && b == ShapeKind::box);
  return one ? Together::halfspace_box : Together::none;
}

bool is_undecided(const PlacedPair& pair, double distance) {
  return std::abs(distance) <= undecided_distance(*pair.a, *pair.pose_a, *pair.b, *pair.pose_b);
}

/// Pairs of boxes, in columns one after the other.
class Boxes {
 public:
  static constexpr std::size_t most = BoxPairRows::most;

  /// Those that are not seen to be apart: their bits. There must be room for a whole list.
  std::uint32_t take(const BoxPairList& pairs, double margin) {
    const std::uint32_t near = take_near_boxes(pairs, margin, rows_, count_);
    count_ += static_cast<std::size_t>(std::popcount(near));
    return near;
  }
  void look(double margin) {
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
  /// The next pair's answer; false if it is to be solved by itself.
  bool answer(const PlacedPair& pair, std::size_t number, double margin, std::vector<Contact>& contacts,
              AnswerSink& answers) {
    const std::size_t k = next_++, first = contacts.size();
    const std::int64_t finding = found_.finding[k];
    if (finding == BoxFinding::apart) return true;
    // By itself where rounding decides whether they touch.
    if (finding == BoxFinding::unknown || is_undecided(pair, found_.distance[k])) {
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

/// A half-space and a box each.
class HalfspaceBoxes {
 public:
  static constexpr std::size_t most = HalfspaceBoxList::most;

  void add(const PlacedPair& pair) {
    const bool reversed = pair.a->kind() == ShapeKind::box;
    const Shape &halfspace = reversed ? *pair.b : *pair.a, &box = reversed ? *pair.a : *pair.b;
    const Pose &at = reversed ? *pair.pose_b : *pair.pose_a, &box_at = reversed ? *pair.pose_a : *pair.pose_b;
    // Most boxes lie on the same one.
    if (list_.count == 0 || &halfspace != last_.shape || &at != last_.pose || reversed != last_.reversed) {
      placed_[places_++] = {at.rotation * halfspace.normal(), halfspace.offset(), at.translation,
                            reversed ? -1.0 : 1.0};
      last_ = {&halfspace, &at, reversed};
    }
    list_.halfspace[list_.count] = &placed_[places_ - 1];
    list_.pose[list_.count] = &box_at;
    list_.half[list_.count++] = &box.parameters();
  }
  void look(double margin) {
    if (list_.count == 0) return;
    find_on_halfspaces(list_, margin, found_);
    list_.count = next_ = places_ = 0;
  }
  bool answer(const PlacedPair& pair, std::size_t number, double margin, std::vector<Contact>& contacts,
              AnswerSink& answers) {
    const std::size_t k = next_++;
    if (!found_.known[k] || is_undecided(pair, found_.distance[k])) return false;
    if (found_.distance[k] > margin) return true;
    if (found_.corners[k] == 0) return false;  // rounding left nothing of a corner that just touches
    PairAnswer& answer = answers.begin(number);
    answer.collide = found_.distance[k] <= 0;
    found_.answers.copy(k, found_.contacts[0], answer);
    // All four are written, and those that do not touch are written over: which they are nothing foresees.
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
  struct Source {
    const Shape* shape;
    const Pose* pose;
    bool reversed;
  };

  std::size_t next_ = 0, places_ = 0;
  HalfspaceBoxList list_;
  PlacedHalfspace placed_[most];
  Source last_;  // of the last one placed
  HalfspaceBoxFindings found_;
};

}  // namespace

void SeveralPairs::solve(std::span<const PlacedPair> pairs, std::vector<Contact>& contacts, AnswerSink& answers) const {
  constexpr std::size_t block = BoxPairList::most;
  Boxes boxes;
  HalfspaceBoxes halfspace_boxes;
  struct Waiting {
    std::uint32_t pair;
    Together kind;
  };
  std::array<Waiting, 3 * block> waiting;
  static_assert(waiting.size() <= Boxes::most && waiting.size() <= HalfspaceBoxes::most);
  std::size_t count = 0;
  const auto answer_waiting = [&] {
    boxes.look(margin_);
    halfspace_boxes.look(margin_);
    for (const auto& [i, kind] : std::span(waiting).first(count)) {
      const PlacedPair& pair = pairs[i];
      if (kind == Together::boxes && boxes.answer(pair, i, margin_, contacts, answers)) continue;
      if (kind == Together::halfspace_box && halfspace_boxes.answer(pair, i, margin_, contacts, answers)) continue;
      PairAnswer& answer = answers.begin(i);
      answer = one_by_one_.solve(*pair.a, *pair.pose_a, *pair.b, *pair.pose_b, Request::contacts, &contacts);
      answers.end();
    }
    count = 0;
  };
  for (std::size_t first = 0; first < pairs.size(); first += block) {
    const auto some = pairs.subspan(first, std::min(block, pairs.size() - first));
    std::array<Together, block> kinds;
    std::array<std::uint8_t, block> place;
    BoxPairList list;
    std::uint32_t left = 0;  // bits of those that must be answered
    for (std::size_t i = 0; i < some.size(); ++i) {
      kinds[i] = by_kind_ ? together(some[i]) : Together::none;
      if (kinds[i] == Together::boxes) {
        place[list.count] = static_cast<std::uint8_t>(i);
        list.add(some[i]);
      } else {
        left |= std::uint32_t{1} << i;
      }
    }
    for (std::uint32_t near = boxes.take(list, margin_); near != 0; near &= near - 1)
      left |= std::uint32_t{1} << place[static_cast<std::size_t>(std::countr_zero(near))];
    for (; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      if (kinds[i] == Together::halfspace_box) halfspace_boxes.add(some[i]);
      waiting[count++] = {static_cast<std::uint32_t>(first + i), kinds[i]};
    }
    if (count > waiting.size() - block) answer_waiting();
  }
  answer_waiting();
}

}  // namespace tandem
