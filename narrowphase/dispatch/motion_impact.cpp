// The first touch of two bodies that move on screws: conservative advancement (Mirtich, Impulse-based dynamic
// simulation of rigid body systems, 1996), best first over the hierarchies of meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory_resource>
#include <queue>
#include <stdexcept>
#include <utility>
#include <vector>

#include "boxes/box_box.h"
#include "convex/feature_normals.h"
#include "dispatch/swept_body.h"
#include "pairs/convex_pair.h"
#include "shapes/screw_path.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t usual_items = 128;  // that wait; more take memory

/// Two bodies on their paths.
class ScrewSweep {
 public:
  ScrewSweep(const SweptBody& a, const ScrewPath& path_a, const SweptBody& b, const ScrewPath& path_b, double radius,
             double gap_of_touch, const WorkLimit* limit)
      : meter_(limit), a_(a), b_(b), path_a_(path_a), path_b_(path_b), radius_(radius), gap_of_touch_(gap_of_touch) {
    const auto reach = [](const SweptBody& s, const ScrewPath& path) {
      return s.mid.norm() + s.half.norm() + path.at(0).translation.norm() + path.length(0);
    };
    box_slack_ = tolerance::place_rounding * (reach(a, path_a) + reach(b, path_b));
    const auto length = [](const SweptBody& s, const ScrewPath& path) {
      return path.length(s.mid.norm() + s.half.norm());
    };
    const double turn = (is_plane(a) ? path_a.angle() : 0) + (is_plane(b) ? path_b.angle() : 0);
    coriolis_ = 2 * turn * (length(a, path_a) + length(b, path_b));
  }

  /// The time of the first touch, and the triangles; `never` if there is none.
  FirstTouch first() {
    FirstTouch best;
    best.t = never;
    alignas(Item) std::array<std::byte, usual_items * sizeof(Item)> usual;
    std::pmr::monotonic_buffer_resource memory(usual.data(), usual.size());
    std::pmr::vector<Item> room(&memory);
    room.reserve(usual_items);
    std::priority_queue<Item, std::pmr::vector<Item>> queue(std::less<Item>(), std::move(room));
    const auto push = [&](std::uint32_t x, std::uint32_t y, double from) {
      if (const double t = boxes_meet(x, y, from, std::min(best.t, 1.0)); t < best.t) queue.push({t, x, y});
    };
    push(whole, whole, 0);
    while (!queue.empty() && queue.top().bound < best.t) {
      meter_.spend(8);
      const Item top = queue.top();
      queue.pop();
      const bool leaf_a = a_.is_leaf(top.a), leaf_b = b_.is_leaf(top.b);
      if (leaf_a && leaf_b) {
        a_.each_convex(top.a, [&](const ConvexView& p, std::uint32_t i) {
          b_.each_convex(top.b, [&](const ConvexView& q, std::uint32_t j) {
            const double t =
                convex_meet(p, a_.core_box(top.a), q, b_.core_box(top.b), top.bound, std::min(best.t, 1.0));
            if (t < best.t) best.t = t, best.feature = {i, j};
          });
        });
      } else if (leaf_b || (!leaf_a && a_.box(top.a).second.norm() >= b_.box(top.b).second.norm())) {
        each_child(*a_.mesh, top.a, [&](std::uint32_t x) { push(x, top.b, top.bound); });
      } else {
        each_child(*b_.mesh, top.b, [&](std::uint32_t y) { push(top.a, y, top.bound); });
      }
    }
    return best;
  }

 private:
  using Box = std::pair<Vec3, Vec3>;  // middle and half sizes, in the body's frame

  static bool is_plane(const SweptBody& body) {
    return body.view.kind == ShapeKind::halfspace || body.view.kind == ShapeKind::plane;
  }

  /// Another body's box as `own` sees it.
  static Box seen_from(const Pose& own, const Pose& other, const Box& box) {
    const Mat3 back = own.rotation.transpose();
    return {back * (other * box.first - own.translation), (back * other.rotation).cwiseAbs() * box.second};
  }

  /// How fast the gap along the normal may shrink at time t. A half-space does not turn in its own frame, in which the
  /// other body passes it: what counts is how its points go where the other's are, not how those far out do.
  double approach(const Vec3& normal, const Pose& at_a, const Pose& at_b, double t, const Box& box_a, const Box& box_b,
                  bool planes) const {
    const Box a = planes && is_plane(a_) ? seen_from(at_a, at_b, box_b) : box_a,
              b = planes && is_plane(b_) ? seen_from(at_b, at_a, box_a) : box_b;
    return path_a_.speed_along(normal, at_a, t, a.first, a.second) +
           path_b_.speed_along(-normal, at_b, t, b.first, b.second);
  }

  /// How far one advances that creeps along a gap, where the points' fastest speed says little: `least`, or longer.
  /// Apart by v along the gap's normal at the end of an advance of length dt, too, they are apart in between where
  /// acceleration * dt^2 / 2 <= (gap^(1/2) + v^(1/2))^2: each two points come no nearer than a parabola through both
  /// ends.
  template <class Separation>
  double glide(double t, double until, double gap, double acceleration, double least, Separation&& separation) const {
    for (double dt = std::min(2 * std::sqrt(2 * gap / acceleration), until - t); dt > 2 * least; dt /= 4) {
      const double end = t + dt;
      const double v = separation(path_a_.at(end), path_b_.at(end)) - radius_;
      const double length = std::sqrt(gap) + std::sqrt(std::max(v, 0.0));
      if (v >= 0 && acceleration * dt * dt <= 2 * length * length) return dt;
    }
    return least;
  }

  /// Advances from `from`, at most `most` times, while the gap that `distance` tells at a time is no touch: no time
  /// that is passed over has one. Returns `never` beyond `until`. `planes`: gaps to a half-space are to its plane.
  /// `separation` is that along a normal at a time, for many advances.
  template <class Distance, class Separation>
  double advance(const Box& box_a, const Box& box_b, double from, double until, int most, bool planes,
                 Distance&& distance, Separation&& separation) {
    constexpr int few_advances = 64;  // then it creeps
    double t = from;
    for (int i = 0; i < most; ++i) {
      meter_.spend(8);
      const Pose at_a = path_a_.at(t), at_b = path_b_.at(t);
      const auto [signed_distance, normal] = distance(at_a, at_b);
      const double gap = signed_distance - radius_;
      if (gap <= gap_of_touch_) return t;
      // Along the normal the two approach each other by at most speed * dt + acceleration * dt^2 / 2.
      const double speed = approach(normal, at_a, at_b, t, box_a, box_b, planes);
      const double acceleration = path_a_.acceleration(box_a.first, box_a.second) +
                                  path_b_.acceleration(box_b.first, box_b.second) + (planes ? coriolis_ : 0);
      const double closing = speed + std::sqrt(speed * speed + 2 * acceleration * gap);
      if (!(closing > 0)) return never;
      double dt = 2 * gap / closing;
      if (i >= few_advances)
        dt = glide(t, until, gap, acceleration, dt,
                   [&, n = normal](const Pose& then_a, const Pose& then_b) { return separation(n, then_a, then_b); });
      const double next = t + dt;
      if (!(next <= until)) return never;
      if (next <= t) return t;
      t = next;
    }
    return t;
  }

  /// The boxes are those of the cores.
  double convex_meet(const ConvexView& p, const Box& box_p, const ConvexView& q, const Box& box_q, double from,
                     double until) {
    constexpr int most_advances = 10000;  // then it creeps up on a graze: early, never late
    const NarrowPhaseOptions exact;
    const auto distance = [&](const Pose& at_a, const Pose& at_b) {
      const PairAnswer answer = solve_convex(p, at_a, q, at_b, Request::distance, exact, nullptr);
      return std::pair(answer.signed_distance, answer.normal);
    };
    const auto separation = [&](const Vec3& n, const Pose& then_a, const Pose& then_b) {
      // From a half-space its own normal, which turns with it, is the only one.
      if (is_plane(a_) || is_plane(b_)) return distance(then_a, then_b).first;
      return separation_along({p, q, relative(then_a, then_b)}, then_a.rotation.transpose() * n) - core_radius(p) -
             core_radius(q);
    };
    return advance(box_p, box_q, from, until, most_advances, true, distance, separation);
  }

  /// A time before which the boxes of two places do not touch: a few advances, as children will tell more.
  double boxes_meet(std::uint32_t x, std::uint32_t y, double from, double until) {
    if (!a_.mesh && !b_.mesh) return from;
    constexpr int most_advances = 4;
    const Box box_a = a_.box(x), box_b = b_.box(y);
    const auto place = [](const Pose& pose, const Vec3& mid) { return Pose{pose.rotation, pose * mid}; };
    const auto half = [](const Vec3& h) { return HalfSize{h[0], h[1], h[2], 0}; };
    const auto distance = [&](const Pose& at_a, const Pose& at_b) {
      const BoxAnswer answer =
          box_box_distance(half(box_a.second), place(at_a, box_a.first), half(box_b.second), place(at_b, box_b.first));
      return std::pair(answer.local.signed_distance - box_slack_, Vec3(at_a.rotation * answer.local.normal));
    };
    const auto unasked = [](const Vec3&, const Pose&, const Pose&) { return -infinity; };
    return advance(box_a, box_b, from, until, most_advances, false, distance, unasked);
  }

  WorkMeter meter_;
  const SweptBody &a_, &b_;
  const ScrewPath &path_a_, &path_b_;
  const double radius_, gap_of_touch_;
  double box_slack_;  // numbers in hierarchies and places are rounded
  double coriolis_;   // acceleration of what passes a half-space that turns, in its frame: at most
};

/// Of an unbounded shape's points only those can be touched that the other one reaches: within this of its origin.
double farthest(const SweptBody& other, const ScrewPath& path, const ScrewPath& own) {
  const double reach = other.mid.norm() + other.half.norm();
  return (path.at(0).translation - own.at(0).translation).norm() + path.length(0) + own.length(0) + reach;
}

}  // namespace

std::optional<FirstTouch> NarrowPhase::time_of_impact(const Shape& a, const Motion& motion_a, const Shape& b,
                                                      const Motion& motion_b) const {
  if (const std::string why = refuses(a, b, Request::distance); !why.empty()) throw std::invalid_argument(why);
  const ScrewPath path_a(motion_a), path_b(motion_b);
  const auto touch_at = [&](FirstTouch touch) {
    const PairAnswer then = unless_stopped(
        NarrowPhase(without_cutoff(options_)).solve(a, path_a.at(touch.t), b, path_b.at(touch.t), Request::distance));
    touch.point = 0.5 * (then.point_a + then.point_b);
    touch.normal = then.normal;
    return touch;
  };
  if (unless_stopped(solve(a, path_a.at(0), b, path_b.at(0), Request::collide)).collide) return touch_at({});
  SweptBody body_a(a, options_.limit), body_b(b, options_.limit);
  const auto limit = [](SweptBody& unbounded, double within) {
    unbounded.mid.setZero();
    unbounded.half.setConstant(within);
  };
  if (!a.is_bounded()) limit(body_a, farthest(body_b, path_b, path_a));
  if (!b.is_bounded()) limit(body_b, farthest(body_a, path_a, path_b));
  const auto reach = [](const SweptBody& body) { return body.mid.norm() + body.half.norm(); };
  const double radius = a.rounding() + b.rounding();
  const double path =
      path_a.length(a.is_bounded() ? reach(body_a) : 0) + path_b.length(b.is_bounded() ? reach(body_b) : 0);
  const double gap_of_touch = tolerance::touch * (a.size() + b.size() + radius) + tolerance::motion_touch * path;
  const FirstTouch first = ScrewSweep(body_a, path_a, body_b, path_b, radius, gap_of_touch, options_.limit).first();
  if (first.t == never) return std::nullopt;
  return touch_at(first);
}

}  // namespace tandem
