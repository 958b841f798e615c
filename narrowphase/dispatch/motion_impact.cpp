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
#include "dispatch/swept_body.h"
#include "pairs/convex_pair.h"
#include "shapes/screw_path.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t usual_items = 128;  // the usual number of waiting items; more allocate memory

/// Two bodies on their screw paths.
class ScrewSweep {
 public:
  ScrewSweep(const SweptBody& a, const ScrewPath& path_a, double rounding_a, const SweptBody& b,
             const ScrewPath& path_b, double rounding_b, double gap_of_touch, const WorkLimit* limit)
      : meter_(limit),
        a_(a),
        b_(b),
        path_a_(path_a),
        path_b_(path_b),
        rounding_a_(rounding_a),
        rounding_b_(rounding_b),
        gap_of_touch_(gap_of_touch) {
    const auto reach = [](const SweptBody& s, const ScrewPath& path) {
      return s.mid.norm() + s.half.norm() + path.at(0).translation.norm() + path.length(0);
    };
    box_slack_ = tolerance::place_rounding * (reach(a, path_a) + reach(b, path_b));
    coriolis_ = 2 * (path_a.fastest(a.mid, a.half) + path_b.fastest(b.mid, b.half));
  }

  /// The time of the first contact, and the triangles; `never` if there is none.
  FirstTouch first() {
    FirstTouch best;
    best.t = never;
    alignas(Item) std::array<std::byte, usual_items * sizeof(Item)> usual;
    std::pmr::monotonic_buffer_resource memory(usual.data(), usual.size());
    std::pmr::vector<Item> items(&memory);
    items.reserve(usual_items);
    std::priority_queue<Item, std::pmr::vector<Item>> queue(std::less<Item>(), std::move(items));
    const auto push = [&](std::uint32_t x, std::uint32_t y, double from) {
      if (const double t = boxes_meet(x, y, from, std::min(best.t, 1.0)); t < best.t) queue.push({t, x, y});
    };
    push(a_.root(), b_.root(), 0);
    while (!queue.empty() && queue.top().bound < best.t) {
      meter_.spend(8);
      const Item top = queue.top();
      queue.pop();
      const bool leaf_a = a_.is_leaf(top.a), leaf_b = b_.is_leaf(top.b);
      if (leaf_a && leaf_b) {
        a_.each_convex(top.a, [&](const ConvexView& p, const Vec3& origin_p, std::uint32_t i) {
          b_.each_convex(top.b, [&](const ConvexView& q, const Vec3& origin_q, std::uint32_t j) {
            const FirstTouch touch = convex_meet({p, origin_p, a_.core_box(top.a)}, {q, origin_q, b_.core_box(top.b)},
                                                 top.bound, std::min(best.t, 1.0));
            if (touch.t < best.t) best = touch, best.feature = {i, j};
          });
        });
      } else if (leaf_b || (!leaf_a && a_.box(top.a).second.norm() >= b_.box(top.b).second.norm())) {
        a_.each_child_of(top.a, [&](std::uint32_t x) { push(x, top.b, top.bound); });
      } else {
        b_.each_child_of(top.b, [&](std::uint32_t y) { push(top.a, y, top.bound); });
      }
    }
    return best;
  }

 private:
  using Box = std::pair<Vec3, Vec3>;  // centre and half sizes, in the body's frame

  /// The gap between two surfaces.
  struct Gap {
    double length;
    Vec3 normal;  // unit, world, from A to B
  };

  static bool is_plane(const SweptBody& body) {
    return body.view.kind == ShapeKind::halfspace || body.view.kind == ShapeKind::plane;
  }

  /// The box of another body in the frame of `own`.
  static Box seen_from(const Pose& own, const Pose& other, const Box& box) {
    const Mat3 back = own.rotation.transpose();
    return {back * (other * box.first - own.translation), (back * other.rotation).cwiseAbs() * box.second};
  }

  /// The accelerations of two boxes' points; `turning`: of a point in the frame of a rotating half-space, in addition,
  /// relative to the angle of the rotation.
  struct Bends {
    ScrewPath::Bend a, b;
    double turning;
  };

  /// How the gap along the normal may shrink: by at most speed * dt + acceleration * dt^2 / 2 while the normal does not
  /// turn.
  struct Approach {
    double speed, acceleration;
  };

  /// At time t. A half-space does not turn in its own frame, in which the other body passes it: the speed of its points
  /// near the other body counts, not that of far ones. There its normal does not turn either; as seen from the other
  /// body's axis it moves on a cone.
  Approach approach(const Vec3& normal, const Pose& at_a, const Pose& at_b, double t, const Box& box_a,
                    const Box& box_b, const Bends& bends, bool planes) const {
    const bool plane_a = planes && is_plane(a_), plane_b = planes && is_plane(b_);
    const Box a = plane_a ? seen_from(at_a, at_b, box_b) : box_a, b = plane_b ? seen_from(at_b, at_a, box_a) : box_b;
    const auto [along_a, turns_a] = path_a_.speed_along(normal, at_a, t, a.first, a.second);
    const auto [along_b, turns_b] = path_b_.speed_along(-normal, at_b, t, b.first, b.second);
    if (!plane_a && !plane_b) return {along_a + along_b, bends.a.along(turns_a) + bends.b.along(turns_b)};
    const double angle_a = path_a_.angle(), angle_b = path_b_.angle(), own = plane_a ? turns_a : turns_b;
    const auto on_cone = [](double turns, double angle, double by, double of) {
      return of > 0 ? std::min(angle, turns + 2 * angle * by / of) : turns;
    };
    const double seen_a = plane_b ? on_cone(turns_a, angle_a, turns_b, angle_b) : turns_a,
                 seen_b = plane_a ? on_cone(turns_b, angle_b, turns_a, angle_a) : turns_b;
    return {along_a + along_b, bends.a.along(seen_a) + bends.b.along(seen_b) + own * bends.turning};
  }

  /// A half-space's or plane's normal turns with it; the direction of another gap does not change.
  Vec3 carried(const Vec3& normal, double from, double to) const {
    if (!is_plane(a_) && !is_plane(b_)) return normal;
    const ScrewPath& path = is_plane(a_) ? path_a_ : path_b_;
    return path.at(to).rotation * (path.at(from).rotation.transpose() * normal);
  }

  /// The length of an advance that creeps along a gap, where the points' highest speed is too coarse a bound: `least`,
  /// or longer, up to `longest`. Let the direction of the gap turn evenly into that of the gap v at the end of an
  /// advance of length dt. Two points then come no nearer along it than a parabola through both ends: they are apart in
  /// between, if bend * dt^2 / 2 <= (gap^(1/2) + v^(1/2))^2. Along a direction n that turns at the rate w, their
  /// distance has the second derivative (b'' - a'') . n + 2 (b' - a') . n' - w^2 (b - a) . n, whose last term only
  /// separates them; n differs from the first normal by at most the turn. On the other side of a plane the direction
  /// would have turned by half a circle, which is excluded at this rate. `points`: their highest speed, and
  /// acceleration along the first normal.
  template <class Distance>
  double glide(double t, const Gap& now, const Approach& points, double acceleration_of_any, double least,
               double longest, Distance&& distance) const {
    for (double dt = longest; dt > 2 * least; dt /= 4) {
      const Gap then = distance(path_a_.at(t + dt), path_b_.at(t + dt));
      if (!(then.length >= 0)) continue;
      const Vec3 along = carried(now.normal, t, t + dt);
      const double turn = 2 * std::atan2((then.normal - along).norm(), (then.normal + along).norm());
      const double length = std::sqrt(now.length) + std::sqrt(then.length);
      const double bend = points.acceleration + turn * acceleration_of_any;
      if ((bend * dt + 2 * points.speed * turn) * dt <= 2 * length * length) return dt;
    }
    return least;
  }

  /// Advances from `from`, at most `most_advances` times, while `distance` reports a gap that is no touch: no skipped
  /// time has a contact. Returns `never` beyond `until`. `planes`: gaps to a half-space are measured to its plane.
  /// `work`: units of one advance.
  template <class Distance>
  double advance(const Box& box_a, const Box& box_b, double from, double until, int most_advances, bool planes,
                 int work, Distance&& distance) {
    constexpr int few_advances = 64;  // afterwards it creeps
    const Bends bends{path_a_.bend(box_a.first, box_a.second), path_b_.bend(box_b.first, box_b.second),
                      planes ? coriolis_ : 0};
    double t = from, stride = until - from;
    for (int i = 0; i < most_advances; ++i) {
      meter_.spend(work);
      const Pose at_a = path_a_.at(t), at_b = path_b_.at(t);
      const Gap gap = distance(at_a, at_b);
      if (gap.length <= gap_of_touch_) return t;
      const auto [speed, acceleration] = approach(gap.normal, at_a, at_b, t, box_a, box_b, bends, planes);
      const double closing = speed + std::sqrt(speed * speed + 2 * acceleration * gap.length);
      if (!(closing > 0)) return never;
      double dt = 2 * gap.length / closing;
      if (i >= few_advances) {
        const double fastest = path_a_.fastest(box_a.first, box_a.second) + path_b_.fastest(box_b.first, box_b.second);
        const double angles = path_a_.angle() + path_b_.angle();
        const double most = bends.a.along(path_a_.angle()) + bends.b.along(path_b_.angle()) + angles * bends.turning;
        dt = stride = glide(t, gap, {fastest, acceleration}, most, dt, std::min(4 * stride, until - t), distance);
      }
      const double next = t + dt;
      if (!(next <= until)) return never;
      if (next <= t) return t;
      t = next;
    }
    return t;
  }

  /// A convex shape whose frame stands somewhere in the body's; the box is that of its core.
  struct Piece {
    const ConvexView& view;
    const Vec3& origin;
    const Box box;
    Pose at(const Pose& body) const { return {body.rotation, body * origin}; }
  };

  FirstTouch convex_meet(const Piece& p, const Piece& q, double from, double until) {
    constexpr int most_advances = 10000;  // then it creeps up on a graze: early, never late
    const NarrowPhaseOptions exact;
    const auto answer_at = [&](const Pose& at_a, const Pose& at_b) {
      return solve_convex(p.view, p.at(at_a), q.view, q.at(at_b), Request::distance, exact, nullptr);
    };
    const auto distance = [&](const Pose& at_a, const Pose& at_b) {
      const PairAnswer answer = answer_at(at_a, at_b);
      return Gap{answer.signed_distance - (rounding_a_ + rounding_b_), answer.normal};
    };
    FirstTouch touch;
    touch.t = advance(p.box, q.box, from, until, most_advances, true, work_of_advance(p.view, q.view), distance);
    if (touch.t == never) return touch;
    const PairAnswer answer = answer_at(path_a_.at(touch.t), path_b_.at(touch.t));
    touch.normal = answer.normal;
    touch.point = 0.5 * (answer.point_a + rounding_a_ * answer.normal + answer.point_b - rounding_b_ * answer.normal);
    return touch;
  }

  /// A time before which the boxes of two nodes do not touch: a few advances only, as the children give better bounds.
  double boxes_meet(std::uint32_t x, std::uint32_t y, double from, double until) {
    if (!a_.has_hierarchy() && !b_.has_hierarchy()) return from;
    constexpr int most_advances = 4, work_of_boxes = 8;
    const Box box_a = a_.box(x), box_b = b_.box(y);
    const auto place = [](const Pose& pose, const Vec3& mid) { return Pose{pose.rotation, pose * mid}; };
    const auto half = [](const Vec3& h) { return HalfSize{h[0], h[1], h[2], 0}; };
    const auto distance = [&](const Pose& at_a, const Pose& at_b) {
      const BoxAnswer answer =
          box_box_distance(half(box_a.second), place(at_a, box_a.first), half(box_b.second), place(at_b, box_b.first));
      return Gap{answer.local.signed_distance - box_slack_ - (rounding_a_ + rounding_b_),
                 at_a.rotation * answer.local.normal};
    };
    return advance(box_a, box_b, from, until, most_advances, false, work_of_boxes, distance);
  }

  WorkMeter meter_;
  const SweptBody &a_, &b_;
  const ScrewPath &path_a_, &path_b_;
  const double rounding_a_, rounding_b_, gap_of_touch_;
  double box_slack_;  // rounding of coordinates in hierarchies
  double coriolis_;  // upper bound on the acceleration of a point in a rotating frame, relative to the rotation's speed
};

/// The largest distance from an unbounded shape's origin of points that the other shape can reach.
double farthest(const SweptBody& other, const ScrewPath& path, const ScrewPath& own) {
  const double reach = other.mid.norm() + other.half.norm();
  return (path.at(0).translation - own.at(0).translation).norm() + path.length(0) + own.length(0) + reach;
}

/// The largest distance of a bounded shape's points from its origin.
double shape_reach(const Shape& shape, const WorkLimit* limit) {
  if (!shape.is_bounded()) return 0;
  const Bounds box = quick_bounds(shape, Pose{}, limit);
  return ((box.lo + box.hi) / 2).norm() + ((box.hi - box.lo) / 2).norm();
}

/// The axis about which a shape is one of revolution.
std::optional<Vec3> axis_of_revolution(const Shape& shape) {
  switch (shape.kind()) {
    case ShapeKind::capsule:
    case ShapeKind::cylinder:
    case ShapeKind::cone:
      return Vec3::UnitZ();
    case ShapeKind::ellipsoid: {
      const Vec3 r = shape.radii();
      for (int k = 0; k < 3; ++k)
        if (r[(k + 1) % 3] == r[(k + 2) % 3]) return Vec3::Unit(k);
      return std::nullopt;
    }
    default:
      return std::nullopt;
  }
}

/// What a shape on its path adds to the gap up to which two count as touching, metres.
double touch_share(const Shape& shape, const ScrewPath& path, const WorkLimit* limit) {
  return tolerance::touch * (shape.size() + shape.rounding()) +
         tolerance::motion_touch * path.length(shape_reach(shape, limit));
}

}  // namespace

std::optional<FirstTouch> NarrowPhase::time_of_impact(const Shape& a, const Motion& motion_a, const Shape& b,
                                                      const Motion& motion_b) const {
  if (const std::string why = refuses(a, b, Request::distance); !why.empty()) throw std::invalid_argument(why);
  const ScrewPath path_a(motion_a, axis_of_revolution(a)), path_b(motion_b, axis_of_revolution(b));
  if (unless_stopped(solve(a, path_a.at(0), b, path_b.at(0), Request::collide)).collide) {
    const PairAnswer now = unless_stopped(
        NarrowPhase(without_cutoff(options_)).solve(a, path_a.at(0), b, path_b.at(0), Request::distance));
    return FirstTouch{0, 0.5 * (now.point_a + now.point_b), now.normal};
  }
  SweptBody body_a(a, options_.limit), body_b(b, options_.limit);
  const auto limit = [](SweptBody& unbounded, double within) {
    unbounded.mid.setZero();
    unbounded.half.setConstant(within);
  };
  if (!a.is_bounded()) limit(body_a, farthest(body_b, path_b, path_a));
  if (!b.is_bounded()) limit(body_b, farthest(body_a, path_a, path_b));
  const double gap_of_touch = touch_share(a, path_a, options_.limit) + touch_share(b, path_b, options_.limit);
  const FirstTouch first =
      ScrewSweep(body_a, path_a, a.rounding(), body_b, path_b, b.rounding(), gap_of_touch, options_.limit).first();
  if (first.t == never) return std::nullopt;
  return first;
}

}  // namespace tandem
