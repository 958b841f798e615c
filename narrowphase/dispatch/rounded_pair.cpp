// Pairs of shapes with rounding: the answer of their cores, adjusted by the radii.
#include "dispatch/rounded_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "manifold/manifold.h"
#include "meshes/mesh_solvers.h"
#include "meshes/traversal/least_translation.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/posed_mesh.h"
#include "shapes/undecided.h"
#include "tolerances.h"

namespace tandem {
namespace {

class RoundedPair {
 public:
  RoundedPair(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const NarrowPhaseOptions& options)
      : a_(a), b_(b), pose_a_(pose_a), pose_b_(pose_b), options_(options), radius_(a.rounding() + b.rounding()) {
    slack_ = tolerance::rounded_translation_slack *
             (a.size() + b.size() + (pose_b.translation - pose_a.translation).lpNorm<1>());
    undecided_ = undecided_distance(a, pose_a, b, pose_b);
  }

  PairAnswer distance(WarmStart* warm) const {
    PairAnswer answer = solve_cores(a_, pose_a_, b_, pose_b_, Request::distance, options_, nullptr, warm);
    grow(answer);
    if (answer.signed_distance < 0 && has_mesh()) bound_depth(answer);
    return answer;
  }

  PairAnswer contacts(std::vector<Contact>& contacts, WarmStart* warm) const {
    const std::size_t first = contacts.size();
    NarrowPhaseOptions wider = options_;
    wider.margin += radius_ + undecided_;
    PairAnswer answer = solve_cores(a_, pose_a_, b_, pose_b_, Request::contacts, wider, &contacts, warm);
    const auto found = [&] { return std::span(contacts).subspan(first); };
    if (found().empty() && both_have_triangles()) return nearest_contact(contacts);
    if (found().empty()) {  // the cores are farther apart than that
      answer.signed_distance = std::max(answer.signed_distance - radius_, options_.margin);
      return answer;
    }
    grow(answer);
    for (Contact& c : found()) {
      c.depth += radius_;
      c.point += 0.5 * (a_.rounding() - b_.rounding()) * c.normal;
    }
    if (std::abs(answer.signed_distance) <= undecided_) take_verdict(answer, found());
    const double least = answer.collide && options_.margin == 0 ? 0 : -options_.margin;
    const auto is_beyond = [&](const Contact& c) {
      return c.depth < least - undecided_ || !(answer.collide || least < 0);
    };
    contacts.erase(std::remove_if(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(), is_beyond),
                   contacts.end());
    for (Contact& c : found()) c.depth = std::max(c.depth, least);
    if (answer.collide && has_mesh()) compare_with_distance(answer, first, contacts);
    return answer;
  }

 private:
  bool has_mesh() const { return !a_.is_convex() || !b_.is_convex(); }
  bool both_have_triangles() const { return has_triangles(a_) && has_triangles(b_); }

  void grow(PairAnswer& answer) const {
    answer.signed_distance -= radius_;
    answer.point_a += a_.rounding() * answer.normal;
    answer.point_b -= b_.rounding() * answer.normal;
    answer.collide = answer.signed_distance <= 0;
  }

  /// Two meshes without a margin have no contacts before they intersect: there is one where they are nearest.
  PairAnswer nearest_contact(std::vector<Contact>& contacts) const {
    PairAnswer answer = distance(nullptr);
    if (answer.signed_distance <= options_.margin)
      contacts.push_back({(answer.point_a + answer.point_b) / 2, answer.normal, -answer.signed_distance, 0});
    if (answer.status != Status::ok && !options_.mesh_bounds) answer.status = Status::unproven, answer.error_bound = 0;
    return answer;
  }

  /// The verdict of the distance, if the difference is within rounding errors.
  void take_verdict(PairAnswer& answer, std::span<Contact> found) const {
    const PairAnswer exact = distance(nullptr);
    answer.collide = exact.collide;
    answer.signed_distance = exact.signed_distance;
    for (Contact& c : found) c.depth = std::min(c.depth, -exact.signed_distance);
    std::max_element(found.begin(), found.end(), [](const Contact& x, const Contact& y) {
      return x.depth < y.depth;
    })->depth = -exact.signed_distance;
  }

  // Relative to A's translation, with B moved: far from the origin, B's would be rounded.
  PairAnswer solve_moved(const Vec3& by, Request request, const NarrowPhaseOptions& options,
                         std::vector<Contact>* contacts) const {
    const Pose at_a{pose_a_.rotation, Vec3::Zero()},
        moved{pose_b_.rotation, pose_b_.translation - pose_a_.translation + by};
    return solve_cores(a_, at_a, b_, moved, request, options, contacts, nullptr);
  }
  bool separates(const Vec3& translation) const {
    return solve_moved(translation, Request::distance, options_, nullptr).signed_distance >= radius_ - slack_;
  }

  /// A translation that separates, off all contacts at once, as in a corner of a mesh; none where they contradict each
  /// other.
  std::optional<Vec3> off_contacts() const {
    NarrowPhaseOptions touching = options_;
    touching.margin = radius_;
    std::vector<Contact> contacts;
    const auto add = [&](const Vec3& at, int, LocalConstraints& off) {
      contacts.clear();
      solve_moved(at, Request::contacts, touching, &contacts);
      return off.add_contacts(contacts, at, radius_);
    };
    const double little = tolerance::alike * (a_.size() + b_.size());
    const OffPrecision precision{slack_ / 8, 0, 0, little};
    return translation_off_all(Vec3::Zero(), precision, add, [&](const Vec3& at) { return !separates(at); });
  }

  /// `answer` has the depth of the cores plus the radii; if that translation does not separate, one off all contacts
  /// does, else that of the hulls.
  void bound_depth(PairAnswer& answer) const {
    const double depth = -answer.signed_distance, certain = depth - answer.error_bound;
    if (separates(depth * answer.normal)) return;
    if (const auto off = off_contacts()) {
      const double length = off->norm();
      answer = solve_moved(*off, Request::distance, options_, nullptr);
      answer.point_a += pose_a_.translation + a_.rounding() * answer.normal;
      answer.point_b = answer.point_a - *off;
      answer.normal = *off / length;
      answer.signed_distance = -length;
    } else {
      const auto hull_of = [this](const Shape& s) { return s.is_convex() ? view(s) : view_hull(s, options_.limit); };
      answer =
          solve_convex(hull_of(a_), pose_a_, hull_of(b_), pose_b_, Request::distance, for_triangles(options_), nullptr);
      grow(answer);
    }
    answer.collide = true;
    answer.status = Status::inexact;
    answer.error_bound = std::max(-answer.signed_distance - certain, slack_);
  }

  /// Which translations of one length separate. Solved once for each direction: contacts of one face have one normal.
  class Escapes {
   public:
    Escapes(const RoundedPair& pair, double length) : pair_(pair), length_(length) {}

    bool operator()(const Vec3& n) {
      for (std::size_t k = 0; k < count_; ++k)
        if (n.dot(known_[k].n) >= tolerance::one_direction) return known_[k].separates;
      const bool separates = pair_.separates(length_ * n);
      if (count_ < most) known_[count_++] = {n, separates};
      return separates;
    }

   private:
    struct Known {
      Vec3 n;
      bool separates;
    };

    static constexpr std::size_t most = 16;

    const RoundedPair& pair_;
    double length_;
    std::array<Known, most> known_;
    std::size_t count_ = 0;
  };

  /// Bounds the error of the deepest contact's depth. Of contacts as deep as the separating translation each has to
  /// separate, as any may be taken for the deepest: those that do not are erased, and if none is left, the translation
  /// is the contact.
  void compare_with_distance(PairAnswer& answer, std::size_t first, std::vector<Contact>& contacts) const {
    if (!options_.mesh_bounds) {
      answer.status = Status::unproven;
      answer.error_bound = 0;
      return;
    }
    const PairAnswer out = distance(nullptr);
    const double depth = -answer.signed_distance, upper = -out.signed_distance, lower = upper - out.error_bound;
    Escapes escapes(*this, depth);
    const auto found = [&] { return std::span(contacts).subspan(first); };
    bool is_free = escapes(answer.normal);
    const auto stays = [&](const Contact& c) { return c.depth < depth - slack_ || escapes(c.normal); };
    if (depth < upper - slack_) {
      is_free = is_free && std::all_of(found().begin(), found().end(), stays);
    } else {
      const bool too_deep = depth > upper + slack_;
      if (too_deep) is_free = is_free && std::all_of(found().begin(), found().end(), stays);
      const auto fails = [&](const Contact& c) {
        return c.depth >= upper - slack_ && (too_deep ? !is_free : !escapes(c.normal));
      };
      contacts.erase(std::remove_if(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(), fails),
                     contacts.end());
      is_free = is_free && make_deepest(depth, found());
      if (!is_free) {
        answer = out;
        if (!make_deepest(upper, found())) contacts.push_back(contact_of(out));
        return;
      }
    }
    const double off = std::max(depth - lower, upper - depth);
    const bool is_exact = is_free && off <= slack_;
    answer.status = is_exact ? Status::ok : Status::inexact;
    answer.error_bound = is_exact ? std::max(off, 0.0) : std::max(off, slack_);
  }

  /// Makes this the depth of the deepest contact, if that is so deep to rounding.
  bool make_deepest(double depth, std::span<Contact> found) const {
    const auto is_less = [](const Contact& x, const Contact& y) { return x.depth < y.depth; };
    const auto deepest = std::max_element(found.begin(), found.end(), is_less);
    if (deepest == found.end() || deepest->depth < depth - slack_) return false;
    for (Contact& c : found) c.depth = std::min(c.depth, depth);
    deepest->depth = depth;
    return true;
  }

  const Shape &a_, &b_;
  const Pose &pose_a_, &pose_b_;
  const NarrowPhaseOptions& options_;
  const double radius_;
  double slack_;
  double undecided_;
};

}  // namespace

PairAnswer solve_rounded(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                         const NarrowPhaseOptions& options, std::vector<Contact>* contacts, WarmStart* warm) {
  NarrowPhaseOptions of_cores = options;
  of_cores.cutoff += a.rounding() + b.rounding();
  const RoundedPair pair(a, pose_a, b, pose_b, of_cores);
  if (request == Request::contacts && contacts != nullptr) return pair.contacts(*contacts, warm);
  PairAnswer answer = pair.distance(warm);
  if (request != Request::collide) return answer;
  PairAnswer verdict;
  verdict.collide = answer.collide;
  return verdict;
}

}  // namespace tandem
