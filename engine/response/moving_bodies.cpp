// The motions of a scene's bodies in a step, and the times at which two of them touch.
#include "response/moving_bodies.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "response/parallel_blocks.h"
#include "scene/swept_boxes.h"
#include "scene/tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t bodies_a_block = 256;
/// Fraction of the inner radius: the core that a continuous body, touching another one at the start, still keeps out of
/// it.
constexpr double core_share = 0.5;

using tolerance::fast_surface;

}  // namespace

Pose Leg::at(double t) const { return t <= begin ? motion.from : pose_at(motion, (t - begin) / (1 - begin)); }

Motion MovingBodies::whole(std::uint32_t body) const {
  const Vec3 centre = scene_->is_static()[body] ? Vec3(Vec3::Zero()) : scene_->shape_of(body).mass().centre;
  return {scene_->poses()[body], ends_[body], centre};
}

Leg MovingBodies::leg(std::uint32_t body) const {
  if (is_watched(body)) return legs_[place_[body]];
  return {0, whole(body), false, length_[body]};
}

void MovingBodies::learn_shapes() {
  if (const SceneChanges::ShapesName now(*scene_); !(now == known_shapes_)) {
    known_shapes_ = now;
    const auto shapes = scene_->shapes();
    balls_.assign(shapes.size(), {});
    has_ball_.assign(shapes.size(), 0);
    reach_.resize(shapes.size());
    for (std::size_t i = 0; i < shapes.size(); ++i) reach_[i] = shapes[i].is_bounded() ? reach_of(shapes[i]) : 0;
  }
  for (std::uint32_t i = 0; i < scene_->indices(); ++i) {
    const std::uint32_t shape = scene_->shape_indices()[i];
    if (!scene_->alive(i) || !scene_->continuous()[i] || has_ball_[shape]) continue;
    balls_[shape] = inner_ball(narrow_, scene_->shapes()[shape]);
    has_ball_[shape] = 1;
  }
}

InnerBall MovingBodies::ball_of(const Scene& scene, std::uint32_t body) const {
  if (scene.continuous()[body] == 0 || scene.is_static()[body] != 0) return {};
  const std::uint32_t shape = scene.shape_indices()[body];
  if (SceneChanges::ShapesName(scene) == known_shapes_ && has_ball_[shape] != 0) return balls_[shape];
  return inner_ball(narrow_, scene.shapes()[shape]);
}

void MovingBodies::measure(std::uint32_t i) {
  const Pose &from = scene_->poses()[i], &to = ends_[i];
  length_[i] = 0;
  if (takes_part_[i] == 0 || (from.translation == to.translation && from.rotation == to.rotation)) return;
  // Far from its origin, a half-space that rotates at all moves arbitrarily far.
  if (!scene_->shape_of(i).is_bounded() && from.rotation != to.rotation)
    length_[i] = std::numeric_limits<double>::max();
  else
    length_[i] = path_length(whole(i), reach_[scene_->shape_indices()[i]]);
}

void MovingBodies::begin(const Scene& scene, std::span<const Pose> ends, std::span<const std::uint8_t> own) {
  scene_ = &scene;
  ends_ = ends;
  watched_.clear();
  legs_.clear();
  const std::size_t count = scene.indices();
  takes_part_.resize(count);
  length_.resize(count);
  place_.assign(count, none);
  for (std::uint32_t i = 0; i < count; ++i)
    takes_part_[i] = scene.alive(i) && scene.is_sensor()[i] == 0 && (own.empty() || own[i] != 0) ? 1 : 0;
  learn_shapes();
  ParallelTime unused;
  for_blocks(count, bodies_a_block, unused, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) measure(static_cast<std::uint32_t>(i));
  });
}

FastestTwo MovingBodies::fastest() const {
  FastestTwo out;
  for (const double length : length_) out.add(length);
  return out;
}

/// Nothing approaches a body faster than the fastest of the others.
bool MovingBodies::watch(const FastestTwo& of_all) {
  for (std::uint32_t i = 0; i < scene_->indices(); ++i) {
    if (scene_->continuous()[i] == 0 || scene_->is_static()[i] != 0 || takes_part_[i] == 0) continue;
    if (!(length_[i] + of_all.of_others(length_[i]) > least_fast_motion(short_motion(i)))) continue;
    place_[i] = static_cast<std::uint32_t>(legs_.size());
    watched_.push_back(i);
    legs_.push_back({0, whole(i), true, 0});
  }
  return !watched_.empty();
}

bool MovingBodies::allows(std::uint32_t a, std::uint32_t b) const {
  const PairFilter filter{scene_->groups(), scene_->masks(), scene_->is_static()};
  if (!filter.allows(a, b)) return false;
  if (!predicate_) return true;
  Pair pair{std::min(a, b), std::max(a, b)};
  return predicate_({&pair, 1}) != 0;
}

bool MovingBodies::may_meet(std::uint32_t a, std::uint32_t b, double t) const {
  const bool watched_a = is_watched(a), watched_b = is_watched(b);
  const auto state = [&](std::uint32_t body, bool watched) {
    return watched ? std::pair(legs_[place_[body]].free, legs_[place_[body]].speed) : std::pair(false, length_[body]);
  };
  const auto [free_a, speed_a] = state(a, watched_a);
  const auto [free_b, speed_b] = state(b, watched_b);
  // If both bodies no longer follow their own motion, the faster one carries the other along, if that is possible.
  if (!free_a && !free_b && !(watched_a && speed_a < speed_b) && !(watched_b && speed_b < speed_a)) return false;
  return left(a, b, t) > least_fast_motion(short_motion(a, b)) && allows(a, b);
}

double MovingBodies::short_motion(std::uint32_t body) const {
  const double radius = balls_[scene_->shape_indices()[body]].radius;
  return radius > 0 ? fast_motion * radius : fast_surface * scene_->shape_of(body).size();
}

double MovingBodies::short_motion(std::uint32_t a, std::uint32_t b) const {
  if (!is_watched(a)) return short_motion(b);
  return is_watched(b) ? std::min(short_motion(a), short_motion(b)) : short_motion(a);
}

double MovingBodies::least_fast_motion(double length) const {
  return length < scene_->gravity.norm() * scene_->dt * scene_->dt ? 0 : length;
}

double MovingBodies::left(std::uint32_t a, std::uint32_t b, double t) const {
  // A body carried by another may reach farther than that one as it rotates: its own length limits this.
  const auto of = [&](std::uint32_t body) {
    if (!is_watched(body)) return (1 - t) * length_[body];
    const Leg& leg = legs_[place_[body]];
    return (1 - t) / (1 - leg.begin) * path_length(leg.motion, reach_[scene_->shape_indices()[body]]);
  };
  return of(a) + of(b);
}

std::optional<BodiesTouch> MovingBodies::core_meets(std::uint32_t a, std::uint32_t b, double t, double soon) const {
  const InnerBall& ball = balls_[scene_->shape_indices()[a]];
  if (ball.radius == 0) return std::nullopt;
  const Shape& other = scene_->shape_of(b);
  const Leg leg_a = leg(a), leg_b = leg(b);
  const auto motion = [&](double from) {
    Motion shifted = leg_a.from(from);
    for (Pose* pose : {&shifted.from, &shifted.to}) pose->translation = *pose * ball.centre;
    shifted.straight_of = *shifted.straight_of - ball.centre;
    return shifted;
  };
  const auto first = [&](double radius, double from) {
    std::optional<BodiesTouch> touch;
    const auto found = narrow_.time_of_impact(Sphere{radius}, motion(from), other, leg_b.from(from));
    if (!found) return touch;
    touch = BodiesTouch{*found, a};
    touch->t = from + touch->t * (1 - from);
    return touch;
  };
  const auto room = [&](double at) {
    return narrow_.solve(Sphere{0}, motion(at).from, other, leg_b.at(at), Request::distance).signed_distance;
  };
  const double radius = core_share * ball.radius, now = room(t);
  // Twice the gap that counts as a touch.
  const double least_gap = 2 * (touch_share(Sphere{radius}, path_length(motion(t), radius)) +
                                touch_share(other, path_length(leg_b.from(t), reach_[scene_->shape_indices()[b]])));
  if (now > 2 * least_gap) return first(std::min(radius, now - least_gap), t);
  // The centre is inside, or on a surface: it may move along and out, not deeper.
  if (room(soon) >= now - least_gap) {
    const auto later = first(radius, soon);
    return later && later->t > soon ? later : std::nullopt;
  }
  const PairAnswer inside = narrow_.solve(Sphere{radius}, motion(t).from, other, leg_b.at(t), Request::distance);
  return BodiesTouch{{t, 0.5 * (inside.point_a + inside.point_b), inside.normal}, a};
}

std::optional<BodiesTouch> MovingBodies::cores_meet(std::uint32_t a, std::uint32_t b, double t, double soon) const {
  std::optional<BodiesTouch> first;
  if (is_watched(a)) first = core_meets(a, b, t, soon);
  if (!is_watched(b)) return first;
  auto other = core_meets(b, a, t, soon);
  if (!other || (first && first->t <= other->t)) return first;
  other->normal = -other->normal;
  return other;
}

/// A future contact; empty also if they touch already, which `touching` tells.
std::optional<BodiesTouch> MovingBodies::whole_meet(std::uint32_t a, std::uint32_t b, double t, bool& touching) const {
  const Motion motion_a = leg(a).from(t), motion_b = leg(b).from(t);
  const Shape &shape_a = scene_->shape_of(a), &shape_b = scene_->shape_of(b);
  touching = narrow_.solve(shape_a, motion_a.from, shape_b, motion_b.from, Request::collide).collide;
  if (touching) return std::nullopt;
  const auto touch = narrow_.time_of_impact(shape_a, motion_a, shape_b, motion_b);
  touching = touch && touch->t == 0;
  if (!touch || touching) return std::nullopt;
  BodiesTouch out{*touch, BodiesTouch::none};
  out.t = t + touch->t * (1 - t);
  return out;
}

std::optional<BodiesTouch> MovingBodies::meet(std::uint32_t a, std::uint32_t b, double t) const {
  bool touching = false;
  auto first = whole_meet(a, b, t, touching);
  if (!touching) return first;
  // They may separate at once, and touch elsewhere.
  const double soon = t + (1 - t) * std::min(1.0, short_motion(a, b) / left(a, b, t));
  first = whole_meet(a, b, soon, touching);
  return touching ? cores_meet(a, b, t, soon) : first;
}

}  // namespace tandem
