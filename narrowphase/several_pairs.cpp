#include "tandem/narrowphase/several_pairs.h"

#include <algorithm>
#include <array>
#include <bit>

#include "box_lanes.h"
#include "halfspace_boxes.h"
#include "manifold.h"
#include "simple_pairs.h"
#include "solvers.h"

namespace tandem {
namespace {

/// The kinds of pairs that are solved together.
enum class Together : std::uint8_t { none, boxes, halfspace_box };

Together together(const PlacedPair& pair) {
  const ShapeKind a = pair.a->kind(), b = pair.b->kind();
  if (a == ShapeKind::box && b == ShapeKind::box) return Together::boxes;
  const bool one =
      (a == ShapeKind::box && b == ShapeKind::halfspace) || (a == ShapeKind::halfspace && b == ShapeKind::box);
  return one ? Together::halfspace_box : Together::none;
}

template <std::size_t columns>
Vec3 vector(const double (&rows)[3][columns], std::size_t column) {
  return {rows[0][column], rows[1][column], rows[2][column]};
}

/// Pairs of boxes, in columns one after the other.
class Boxes {
 public:
  static constexpr std::size_t most = BoxPairRows::most;

  bool full() const { return count_ == most; }
  void add(const PlacedPair& pair) {
    const HalfSize &half_a = pair.a->parameters(), &half_b = pair.b->parameters();
    reversed_[count_] = boxes_reversed(half_a, *pair.pose_a, half_b, *pair.pose_b);
    if (reversed_[count_])
      rows_.set(count_++, half_b, *pair.pose_b, half_a, *pair.pose_a);
    else
      rows_.set(count_++, half_a, *pair.pose_a, half_b, *pair.pose_b);
  }
  void look(double margin) {
    if (count_ == 0) return;
    overlap_boxes(rows_, count_, margin, found_);
    std::size_t patches = 0;
    for (std::size_t k = 0; k < count_; ++k)
      if (found_.finding[k] == BoxFinding::faces) clipped_[patches++] = static_cast<std::int64_t>(k);
    clip_rectangles(found_.faces, clipped_, patches, margin, patches_);
    count_ = next_ = next_patch_ = 0;
  }
  /// The next pair's answer; false if it is to be solved by itself.
  bool answer(const PlacedPair& pair, std::size_t number, double margin, std::vector<Contact>& contacts,
              AnswerSink& answers) {
    const std::size_t k = next_++, first = contacts.size();
    const BoxFinding finding = found_.finding[k];
    if (finding == BoxFinding::apart) return true;
    if (finding == BoxFinding::unknown) return false;
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
      answer.signed_distance = found_.distance[k];
      const double sense = reversed_[k] ? -1 : 1;
      answer.normal = sense * vector(found_.normal, k);
      answer.point_a = vector(reversed_[k] ? found_.on_b : found_.on_a, k);
      answer.point_b = vector(reversed_[k] ? found_.on_a : found_.on_b, k);
      contacts.push_back({vector(found_.point, k), sense * vector(found_.normal, k), found_.depth[k],
                          static_cast<std::uint32_t>(static_cast<std::int64_t>(found_.feature[k]))});
    } else if (reversed_[k]) {
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
    const bool reversed = reversed_[k], tilted = found_.axis[k] >= 6 && found_.facing[k] <= flush_face;
    const Shape &a = reversed ? *pair.b : *pair.a, &b = reversed ? *pair.a : *pair.b;
    const Pose &pose_a = reversed ? *pair.pose_b : *pair.pose_a, &pose_b = reversed ? *pair.pose_a : *pair.pose_b;
    append_box_patch(found_.faces, k, patches_, patch, tilted, a.parameters(), pose_a, b.parameters(), pose_b,
                     vector(found_.normal, k), contacts);
    if (contacts.size() == first) return false;
    if (tilted) {
      answer.collide = true;
      answer.signed_distance = found_.distance[k];
      answer.normal = vector(found_.normal, k);
      answer.point_a = vector(found_.on_a, k);
      answer.point_b = vector(found_.on_b, k);
    } else {
      answer_by_deepest(std::span(contacts).subspan(first), found_.distance[k], answer);
    }
    if (reversed) swap_answer(answer, &contacts, first);
    return true;
  }

  std::size_t count_ = 0, next_ = 0, next_patch_ = 0;
  bool reversed_[most];
  BoxPairRows rows_{};  // columns that are not set are computed with the others: what is in them must be numbers
  BoxFindingRows found_;
  std::int64_t clipped_[most]{};  // columns of rows
  RectanglePatchRows patches_;
};

/// A half-space and a box each.
class HalfspaceBoxes {
 public:
  static constexpr std::size_t most = HalfspaceBoxRows::most;

  bool full() const { return count_ == most; }
  void add(const PlacedPair& pair) {
    const bool reversed = pair.a->kind() == ShapeKind::box;
    const Shape &halfspace = reversed ? *pair.b : *pair.a, &box = reversed ? *pair.a : *pair.b;
    const Pose &at = reversed ? *pair.pose_b : *pair.pose_a, &box_at = reversed ? *pair.pose_a : *pair.pose_b;
    rows_.set(count_++, at.rotation * halfspace.normal(), halfspace.offset(), at.translation, box.parameters(), box_at);
  }
  void look(double margin) {
    if (count_ == 0) return;
    find_on_halfspaces(rows_, count_, margin, found_);
    count_ = next_ = 0;
  }
  bool answer(const PlacedPair& pair, std::size_t number, double margin, std::vector<Contact>& contacts,
              AnswerSink& answers) {
    const std::size_t k = next_++;
    if (!found_.known[k]) return false;
    if (found_.distance[k] > margin) return true;
    if (found_.corners[k] == 0) return false;  // rounding left nothing of a corner that just touches
    const bool reversed = pair.a->kind() == ShapeKind::box;
    const double sense = reversed ? -1 : 1;
    PairAnswer& answer = answers.begin(number);
    answer.signed_distance = found_.distance[k];
    answer.collide = answer.signed_distance <= 0;
    const Vec3 normal = sense * vector(rows_.normal, k);
    answer.normal = normal;
    answer.point_a = vector(reversed ? found_.on_box : found_.on_halfspace, k);
    answer.point_b = vector(reversed ? found_.on_halfspace : found_.on_box, k);
    const auto face = static_cast<std::uint32_t>(static_cast<std::int64_t>(found_.face[k]));
    for (unsigned corners = found_.corners[k]; corners != 0; corners &= corners - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(corners));
      contacts.push_back({vector(found_.point[i], k), normal, found_.depth[i][k], face | i});
    }
    answers.end();
    return true;
  }

 private:
  std::size_t count_ = 0, next_ = 0;
  HalfspaceBoxRows rows_{};
  HalfspaceBoxFindings found_;
};

}  // namespace

void SeveralPairs::solve(std::span<const PlacedPair> pairs, std::vector<Contact>& contacts, AnswerSink& answers) const {
  constexpr std::size_t screened = 32;
  std::array<std::uint8_t, screened> apart;
  Boxes boxes;
  HalfspaceBoxes halfspace_boxes;
  const auto kind_of = [this](const PlacedPair& pair) { return by_kind_ ? together(pair) : Together::none; };
  struct Waiting {
    std::uint32_t pair;
    Together kind;
  };
  std::array<Waiting, 2 * screened> waiting;
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
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::size_t k = i % screened;
    if (k == 0) {
      const auto some = pairs.subspan(i, std::min(screened, pairs.size() - i));
      one_by_one_.mark_apart(some, std::span(apart).first(some.size()));
    }
    if (apart[k] != 0) continue;
    const Together its = kind_of(pairs[i]);
    if (its == Together::boxes) boxes.add(pairs[i]);
    if (its == Together::halfspace_box) halfspace_boxes.add(pairs[i]);
    waiting[count++] = {static_cast<std::uint32_t>(i), its};
    if (count == waiting.size() || boxes.full() || halfspace_boxes.full()) answer_waiting();
  }
  answer_waiting();
}

}  // namespace tandem
