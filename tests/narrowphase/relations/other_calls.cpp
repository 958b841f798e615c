// Relations with other calls: motions, separation along a direction, options, lanes, scenes, features, unions.
#include "other_calls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "checks.h"
#include "surface_distance.h"
#include "tandem/engine/scene.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/clearance.h"
#include "tandem/narrowphase/deformable_mesh.h"
#include "tandem/narrowphase/near_features.h"
#include "tandem/narrowphase/several_pairs.h"
#include "tandem/narrowphase/shape_makers.h"
#include "tandem/narrowphase/triangles_at.h"

namespace tandem::relations {
namespace {

// The pose relative to A's translation: far from the origin, moving a body would round its coordinates.
Pose seen_from(const Pose& pose, const Vec3& origin) { return {pose.rotation, pose.translation - origin}; }

// ---- Motions ----

// A motion with a rotation, on which the body may hit the other one.
Motion any_motion(const Pose& from, const Vec3& step, Random& random) {
  Motion m{from, from};
  m.to.translation += step;
  if (!random.once_in(4)) {
    const Vec3 axis = random.direction();
    const double most = random.in(0, 0.95 * std::numbers::pi), angle = most * (random.once_in(3) ? 0.01 : 1.0);
    m.to.rotation = orthonormalized({Eigen::AngleAxisd(angle, axis).toRotationMatrix() * from.rotation}).rotation;
  }
  if (random.once_in(3)) m.straight_of = Vec3(Vec3::Zero());
  return m;
}

}  // namespace

// There is no overlap before the first touch, a touch at it, and no touch if none is reported; also for screws.
std::string motions(const Case& c, Random& random) {
  const Vec3 origin = c.pair.a.pose.translation;
  const PairAnswer& now = c.answers.distance;
  const double length = std::abs(now.signed_distance) + 0.3 * c.unit;
  Motion a{seen_from(c.pair.a.pose, origin), seen_from(c.pair.a.pose, origin)};
  if (random.once_in(2)) {
    const Vec3 along = random.direction();
    a = any_motion(a.from, random.in(0, 0.3) * length * along, random);
  }
  const Vec3 towards = -now.normal + 0.5 * random.direction();
  const Motion b = any_motion(seen_from(c.pair.b.pose, origin), random.in(0.3, 2) * length * towards, random);
  const auto touch = plain().time_of_impact(c.a, a, c.b, b);
  const auto at = [&](double t) { return distance(c.a, pose_at(a, t), c.b, pose_at(b, t)); };
  const double path = (a.to.translation - a.from.translation).norm() + (b.to.translation - b.from.translation).norm() +
                      4 * c.unit,
               tolerance = 10 * rounding * path;
  if (c.answers.collide && now.signed_distance + now.error_bound < -tolerance)
    return touch && touch->t == 0 ? std::string() : say("a touch later than 0 of shapes that collide");
  const double end = touch ? touch->t : 1.0;
  constexpr int samples = 6;
  for (int k = 0; k <= samples; ++k)
    if (const PairAnswer there = at(end * k / samples); there.signed_distance + there.error_bound < -tolerance)
      return say("they overlap by ", -there.signed_distance, " at ", end * k / samples, ", the touch is ",
                 touch ? say("at ", end) : "missing");
  if (!touch) return {};
  if (const PairAnswer there = at(end); there.signed_distance - there.error_bound > tolerance + early * path)
    return say("a distance of ", there.signed_distance, " at the first touch ", end);
  if (!touch->point.allFinite() || !(std::abs(touch->normal.norm() - 1) < 1e-12))
    return say("a first touch without point or normal");
  const PosedShape there_a{c.pair.a.shape, pose_at(a, end), c.pair.a.rounding},
      there_b{c.pair.b.shape, pose_at(b, end), c.pair.b.rounding};
  if (end > 0)
    for (const PosedShape* s : {&there_a, &there_b})
      if (const double off = surface_distance(*s, s == &there_a ? c.a : c.b, touch->point);
          !(off <= tolerance + 2 * early * path))
        return say("the point of the first touch is ", off, " off ", s == &there_a ? "A" : "B");
  const auto other = plain().time_of_impact(c.b, b, c.a, a);
  if (!other) return say("exchanged: no first touch for one at ", end);
  if (std::abs(other->t - end) * path <= 2 * early * path + tolerance) return {};
  // For bodies that approach slowly both times may be earlier than the touch by more than usual, as a gap counts as a
  // touch: they agree as long as no touch lies between.
  for (int k = 0; k <= samples; ++k)
    if (const PairAnswer there = at(end + (other->t - end) * k / samples);
        there.signed_distance - there.error_bound > tolerance + as_touch * path ||
        there.signed_distance + there.error_bound < -tolerance)
      return say("exchanged: a first touch at ", other->t, " for ", end, ", a distance of ", there.signed_distance,
                 " between them");
  return {};
}

// ---- Contacts and planes ----

// An edge within this angle of the contact plane carries a patch, all of whose points have the depth of the deepest.
constexpr double flush = 1e-6;

// A contact's point is no farther from either body than half its depth.
std::string points_of(const Case& c, std::span<const Contact> contacts, double error_bound) {
  const Shape point(Sphere{0});
  const double tolerance = flush * c.unit + 4 * world_rounding(c.pair) + error_bound;
  for (const Contact& contact : contacts)
    for (const bool first : {true, false}) {
      const Shape& s = first ? c.a : c.b;
      const Pose& pose = first ? c.pair.a.pose : c.pair.b.pose;
      const double off = distance(s, pose, point, {Mat3::Identity(), contact.point}).signed_distance;
      if (off > std::abs(contact.depth) / 2 + tolerance)
        return say("a contact ", contact.depth, " deep is ", off, " off ", first ? "A" : "B");
    }
  return {};
}

// Also within a margin of the gap itself, where rounding decides whether there is a contact.
std::string contact_points(const Case& c, Random&) {
  const Answers& r = c.answers;
  const double error_bound = std::max(r.contacts.error_bound, r.near.error_bound);
  for (const auto* list : {&r.touching, &r.within})
    if (std::string why = points_of(c, *list, error_bound); !why.empty()) return why;
  const double d = r.distance.signed_distance;
  if (!(d > 0)) return {};
  for (const double margin : {d, std::nextafter(d, infinity)}) {
    std::vector<Contact> contacts;
    NarrowPhase({.margin = margin}).solve(c.a, c.pair.a.pose, c.b, c.pair.b.pose, Request::contacts, &contacts);
    if (const std::string why = points_of(c, contacts, r.distance.error_bound); !why.empty())
      return say("within ", margin, ": ", why);
  }
  return {};
}

// Convex bodies lie behind the planes through their witness points, by queries with half-spaces.
std::string planes(const Case& c, Random&) {
  const PairAnswer& r = c.answers.distance;
  if (!c.a.is_convex() || !c.b.is_convex() || !c.a.is_bounded() || !c.b.is_bounded()) return {};
  for (const bool first : {true, false}) {
    const Vec3 normal = first ? Vec3(-r.normal) : r.normal;
    const Vec3 through = first ? r.point_a : r.point_b;
    const PairAnswer plane = distance(Shape(HalfSpace{normal, 0}), {Mat3::Identity(), through}, first ? c.a : c.b,
                                      first ? c.pair.a.pose : c.pair.b.pose);
    const double tolerance = 2 * surface * c.unit + r.error_bound + 4 * world_rounding(c.pair);
    if (!(std::abs(plane.signed_distance) <= tolerance))
      return say(first ? "A" : "B", " is ", plane.signed_distance, " from the plane through its witness point");
  }
  return {};
}

// The separation along a direction is no shorter than the depth, and separates.
std::string along(const Case& c, Random& random) {
  const PairAnswer& r = c.answers.distance;
  const Vec3 origin = c.pair.a.pose.translation;
  const Pose a = seen_from(c.pair.a.pose, origin), b = seen_from(c.pair.b.pose, origin);
  const double tolerance = 4 * rounding * c.unit;
  const bool convex = c.a.is_convex() && c.b.is_convex();
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = k == 0   ? r.normal
                   : k == 1 ? Vec3((r.normal + 0.3 * random.direction()).normalized())
                            : random.direction();
    const double s = separation_along(c.a, a, c.b, b, u);
    if (std::isnan(s) || s < 0) return say("separation along a direction: ", s);
    if (std::isinf(s)) {
      if (c.a.is_bounded() && c.b.is_bounded()) return say("no translation separates bounded shapes");
      continue;
    }
    if (c.answers.collide && s < -r.signed_distance - r.error_bound - tolerance)
      return say("moving by ", s, " separates, the depth is ", -r.signed_distance, " +- ", r.error_bound);
    const auto moved = [&](double by) { return distance(c.a, a, c.b, {b.rotation, b.translation + by * u}); };
    const PairAnswer there = moved(s);
    const double off =
        2 * tolerance + 4 * std::numeric_limits<double>::epsilon() * s;  // with what rounding leaves of the translation
    if (there.signed_distance + there.error_bound < -off)
      return say("moved by the separation ", s, " they overlap by ", -there.signed_distance);
    if (k == 0 && convex && c.answers.collide && r.status == Status::ok &&
        std::abs(s + r.signed_distance) > tolerance + r.error_bound)
      return say("separation ", s, " along the normal, depth ", -r.signed_distance);
    if (s > 0 && there.signed_distance - there.error_bound > off)
      return say("moved by the separation ", s, " along ", u.transpose(), " they are ", there.signed_distance,
                 " apart");
    if (c.answers.collide && s > 100 * tolerance && convex && !(moved(0.99 * s).signed_distance <= tolerance))
      return say("apart already at 0.99 of the separation ", s);
  }
  return {};
}

// ---- Options ----

// Another solver, a tolerance, or parts of the work run by a part runner: the same answer within the tolerance.
std::string options(const Case& c, Random& random) {
  const Pose &a = c.pair.a.pose, &b = c.pair.b.pose;
  const PairAnswer& full = c.answers.distance;
  const double d = full.signed_distance, size = c.a.size() + c.b.size();
  const bool meshes = !c.a.is_convex() || !c.b.is_convex();
  for (const double tolerance : {0.0, 1e-6, 1e-2}) {
    const NarrowPhaseOptions asked{.tolerance = tolerance, .solver = tolerance == 0 && !meshes ? "gjk" : ""};
    const NarrowPhase other(asked);
    if (tolerance == 0 && (meshes || !c.a.is_bounded() || !c.b.is_bounded())) continue;
    const PairAnswer r = other.solve(c.a, a, c.b, b, Request::distance);
    const double allowed = full.error_bound + r.error_bound + std::max(tolerance, surface) * (size + c.unit);
    if (!(std::abs(r.signed_distance - d) <= allowed))
      return say("distance ", r.signed_distance, " +- ", r.error_bound,
                 tolerance == 0 ? " by gjk" : " with a tolerance", ", else ", d);
    if (r.collide != (r.signed_distance <= 0))
      return say("collide ", r.collide, " at ", r.signed_distance, " with options");
    const bool hit = other.solve(c.a, a, c.b, b, Request::collide).collide;
    if (hit != c.answers.collide && std::abs(d) > allowed) return say("collide ", hit, " at ", d, " with options");
  }
  // In any order.
  const NarrowPhase parts(
      {.margin = c.pair.margin, .parts = [](std::size_t n, const std::function<void(std::size_t)>& part) {
         for (std::size_t i = n; i > 0; --i) part(i - 1);
       }});
  std::vector<Contact> contacts;
  const PairAnswer near = parts.solve(c.a, a, c.b, b, Request::contacts, &contacts);
  const auto same_bits = [](const Contact& x, const Contact& y) {
    return x.point == y.point && x.normal == y.normal && x.depth == y.depth && x.feature == y.feature;
  };
  if (near.signed_distance != c.answers.near.signed_distance ||
      !std::equal(contacts.begin(), contacts.end(), c.answers.within.begin(), c.answers.within.end(), same_bits))
    return say("other bits with the parts in another order");
  if (!is_mesh(c.a) || !is_mesh(c.b)) return {};
  contacts.clear();
  const PairAnswer fast = NarrowPhase({.mesh_gaps = random.once_in(2), .mesh_bounds = false})
                              .solve(c.a, a, c.b, b, Request::contacts, &contacts);
  if (fast.collide != c.answers.collide || contacts.empty() == c.answers.collide)
    return say(contacts.size(), " contacts, collide ", fast.collide, " without bounds");
  return {};
}

// ---- Several pairs ----

namespace {

class Answered final : public AnswerSink {
 public:
  Answered(std::size_t pairs, const std::vector<Contact>& contacts) : of(pairs), contacts_(contacts) {}
  PairAnswer& begin(std::size_t pair) override {
    at_ = pair;
    of[pair].given = true;
    of[pair].first = contacts_.size();
    return of[pair].answer;
  }
  void end() override { of[at_].last = contacts_.size(); }
  struct One {
    bool given = false;
    PairAnswer answer;
    std::size_t first = 0, last = 0;
  };
  std::vector<One> of;

 private:
  const std::vector<Contact>& contacts_;
  std::size_t at_ = 0;
};

}  // namespace

// One pair per lane: the pair, its exchange and some near it have the same bits as alone.
std::string lanes(const Case& c, Random& random) {
  struct Placed {
    const Shape* a;
    Pose pose_a;
    const Shape* b;
    Pose pose_b;
  };
  std::vector<Placed> placed;
  const int count = 2 + random.below(11);
  for (int k = 0; k < count; ++k) {
    Placed p{&c.a, c.pair.a.pose, &c.b, c.pair.b.pose};
    if (k > 1) {
      const Vec3 along = random.direction();
      p.pose_b.translation += small(random, 12) * c.unit * along;
    }
    if (random.once_in(6)) p.pose_b.rotation = p.pose_a.rotation;
    if (random.once_in(8) && c.a.is_bounded()) p.b = &c.a;
    if (k % 2 == 1) std::swap(p.a, p.b), std::swap(p.pose_a, p.pose_b);
    placed.push_back(p);
  }
  std::vector<PlacedPair> pairs;
  for (const Placed& p : placed) pairs.push_back({p.a, &p.pose_a, p.b, &p.pose_b});
  const double margin = random.once_in(2) ? 0 : c.pair.margin;
  const NarrowPhase alone({.margin = margin});
  std::vector<Contact> contacts;
  Answered answers(pairs.size(), contacts);
  SeveralPairs({.margin = margin}).solve(pairs, contacts, answers);
  std::vector<std::uint8_t> apart(pairs.size());
  alone.mark_apart(pairs, apart);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    std::vector<Contact> own;
    const PairAnswer r =
        alone.solve(*pairs[k].a, *pairs[k].pose_a, *pairs[k].b, *pairs[k].pose_b, Request::contacts, &own);
    const auto& got = answers.of[k];
    if (apart[k] != 0 && !own.empty()) return say("pair ", k, " of several is marked as apart with contacts");
    if (!got.given) {
      if (!own.empty()) return say("pair ", k, " of several is passed over with contacts");
      continue;
    }
    const auto same_bits = [](const Contact& x, const Contact& y) {
      return x.point == y.point && x.normal == y.normal && x.depth == y.depth && x.feature == y.feature;
    };
    if (!std::equal(own.begin(), own.end(), contacts.begin() + static_cast<std::ptrdiff_t>(got.first),
                    contacts.begin() + static_cast<std::ptrdiff_t>(got.last), same_bits))
      return say("pair ", k, " of several: other contacts, ", got.last - got.first, " for ", own.size());
    if (got.answer.collide != r.collide || (!own.empty() && got.answer.signed_distance != r.signed_distance) ||
        got.answer.status != r.status || got.answer.error_bound != r.error_bound)
      return say("pair ", k, " of several: another answer, ", got.answer.signed_distance, " for ", r.signed_distance);
  }
  return {};
}

// ---- A scene ----

// A scene of one body answers as the pair does.
std::string scene(const Case& c, Random& random) {
  Scene scene;
  const ShapeId shape = scene.add_shape(c.b);
  scene.add_body({.shape = shape, .pose = c.pair.b.pose, .is_static = true});
  // A body that is farther away than any query reaches.
  const ShapeId point = scene.add_shape(Shape(Sphere{0}));
  Pose far = c.pair.a.pose;
  far.translation +=
      (10 + random.unit()) * (c.unit + c.pair.margin + std::abs(c.answers.distance.signed_distance)) * Vec3::UnitX();
  scene.add_body({.shape = point, .pose = far, .is_static = true});
  const SceneQueries queries(scene);
  const Pose& a = c.pair.a.pose;
  const PairAnswer& d = c.answers.distance;
  const bool bounded = c.a.is_bounded() && c.b.is_bounded();
  // A touch that rounding decides, or a gap equal to the margin: the boxes may be separated by rounding.
  const double tie = rounding * c.unit + world_rounding(c.pair);
  if (std::abs(d.signed_distance) <= tie || std::abs(d.signed_distance - c.pair.margin) <= tie) return {};
  if (queries.collides(c.a, a) != c.answers.collide && bounded)
    return say("a scene's collides is ", !c.answers.collide);
  std::vector<BodyId> bodies;
  queries.hits(c.a, a, bodies);
  if ((std::find_if(bodies.begin(), bodies.end(), [](BodyId id) { return id.index() == 0; }) != bodies.end()) !=
      c.answers.collide)
    return say("a scene's hits are ", bodies.size(), ", collide ", c.answers.collide);
  const auto nearest = queries.nearest(c.a, a);
  if (!nearest || (nearest->body.index() == 0 && nearest->answer.signed_distance != d.signed_distance))
    return say("a scene's nearest is ", nearest ? nearest->answer.signed_distance : infinity, " for ",
               d.signed_distance);
  if (bounded && nearest->body.index() != 0) return say("a scene's nearest is another body");
  std::vector<Hit> within;
  queries.within(c.a, a, c.pair.margin, within);
  const bool is_within = !within.empty() && within.front().body.index() == 0;
  if (is_within != (d.signed_distance <= c.pair.margin))
    return say("a scene's within is ", is_within, " at ", d.signed_distance);
  std::vector<ContactHit> hits;
  std::vector<Contact> contacts;
  queries.contacts(c.a, a, c.pair.margin, hits, contacts);
  const std::size_t count = !hits.empty() && hits.front().body.index() == 0 ? hits.front().count : 0;
  if (count != c.answers.within.size()) return say("a scene's contacts are ", count, " for ", c.answers.within.size());
  for (std::size_t k = 0; k < count; ++k)
    if (contacts[hits.front().first + k].depth != c.answers.within[k].depth)
      return say("a scene's contacts are others");
  const double length = std::abs(d.signed_distance) + 0.3 * c.unit;
  const Vec3 towards = d.normal + 0.3 * random.direction();
  const Motion motion = any_motion(a, random.in(0.3, 2) * length * towards, random);
  const auto cast = queries.cast(c.a, motion, {.admits = [](BodyId id) { return id.index() == 0; }});
  const auto alone = plain().time_of_impact(c.a, motion, c.b, {c.pair.b.pose, c.pair.b.pose});
  if (cast.has_value() != alone.has_value() || (cast && std::abs(cast->t - alone->t) > 2 * early))
    return say("a scene's cast hits at ", cast ? cast->t : -1, ", the pair at ", alone ? alone->t : -1);
  return {};
}

// ---- Triangles ----

// Pairs of triangles within a clearance: the nearest has the distance, those that intersect are the list's; the same
// for features.
std::string near_triangles(const Case& c, Random& random) {
  const Pose &a = c.pair.a.pose, &b = c.pair.b.pose;
  if (c.a.triangles().size() * c.b.triangles().size() > 20000) return {};
  const auto list = plain().intersecting_triangles(c.a, a, c.b, b);
  std::vector<std::array<std::uint32_t, 2>> visited, touching;
  double least = infinity;
  const PairAnswer& d = c.answers.distance;
  const double tolerance = rounding * c.unit + 4 * world_rounding(c.pair);
  const double clearance = random.once_in(3) ? 0 : std::abs(d.signed_distance) * (1 + random.unit()) + tolerance;
  visit_triangles(c.a, a, c.b, b,
                  [&](const NearTriangles& pair) {
                    visited.push_back(pair.triangles);
                    if (pair.distance == 0) touching.push_back(pair.triangles);
                    least = std::min(least, pair.distance);
                    return true;
                  },
                  {.clearance = clearance});
  std::sort(visited.begin(), visited.end());
  std::sort(touching.begin(), touching.end());
  if (std::adjacent_find(visited.begin(), visited.end()) != visited.end())
    return say("a pair of triangles is visited twice");
  if (!std::includes(touching.begin(), touching.end(), list.begin(), list.end()))
    return say(touching.size(), " visited pairs of triangles touch, ", list.size(), " intersect");
  if (clearance > 0 && list.empty() && d.signed_distance > tolerance &&
      !(std::abs(least - d.signed_distance) <= tolerance))
    return say("the nearest triangles are ", least, " apart, distance ", d.signed_distance);
  auto turned = plain().intersecting_triangles(c.b, b, c.a, a);
  for (auto& pair : turned) std::swap(pair[0], pair[1]);
  std::sort(turned.begin(), turned.end());
  if (turned != list) return say("exchanged: ", turned.size(), " pairs of triangles for ", list.size());
  if (clearance > 0 && list.empty() && d.signed_distance > 100 * tolerance) {
    const NearFeatures features = near_features(c.a, a, c.b, b, clearance);
    double nearest = infinity;
    for (const auto* points : {&features.points, &features.points_of_b})
      for (const NearPoint& p : *points) nearest = std::min(nearest, p.distance);
    for (const NearEdges& e : features.edges) nearest = std::min(nearest, e.distance);
    if (!(std::abs(nearest - d.signed_distance) <= tolerance))
      return say("the nearest features are ", nearest, " apart, distance ", d.signed_distance);
  }
  const auto zones = clearance_zones(c.a, a, c.b, b, {.clearance = clearance});
  std::size_t all = 0, meeting = 0;
  for (const ClearanceZone& z : zones) all += z.pairs, meeting += z.intersecting_pairs;
  if (all != visited.size() || meeting != touching.size())
    return say("zones of ", all, " pairs of triangles, ", meeting, " intersecting, for ", visited.size(), " and ",
               touching.size());
  return {};
}

// The triangle at a witness point or contact is one at that place.
std::string triangle_places(const Case& c, Random&) {
  const double tolerance = surface * c.unit + 4 * world_rounding(c.pair);
  const auto off = [&](const Shape& s, const Pose& pose, std::uint32_t index, const Vec3& place) {
    const auto& t = s.triangles()[index];
    const Shape triangle(Triangle{{s.vertices()[t[0]], s.vertices()[t[1]], s.vertices()[t[2]]}});
    return std::max(0.0, distance(triangle, pose, Shape(Sphere{0}), {Mat3::Identity(), place}).signed_distance);
  };
  const PairAnswer& r = c.answers.distance;
  if (r.signed_distance > 0 && r.status == Status::ok) {
    const auto at = triangles_at(c.a, c.pair.a.pose, c.b, c.pair.b.pose, r);
    for (const bool first : {true, false}) {
      const Shape& s = first ? c.a : c.b;
      if (!is_mesh(s)) continue;
      if (at[first ? 0 : 1] >= s.triangles().size()) return say("no triangle has the number ", at[first ? 0 : 1]);
      const double far =
          off(s, first ? c.pair.a.pose : c.pair.b.pose, at[first ? 0 : 1], first ? r.point_a : r.point_b);
      if (!(far <= s.rounding() + tolerance)) return say("the witness point is ", far, " from its triangle");
    }
  }
  for (const Contact& contact : c.answers.within) {
    const auto at = triangles_at(c.a, c.pair.a.pose, c.b, c.pair.b.pose, contact);
    for (const bool first : {true, false}) {
      const Shape& s = first ? c.a : c.b;
      if (!is_mesh(s)) continue;
      if (at[first ? 0 : 1] >= s.triangles().size()) return say("no triangle has the number ", at[first ? 0 : 1]);
    }
  }
  return {};
}

// The vertices of A as a cloud of points, or of balls, are as near to B as the nearest ball.
std::string cloud(const Case& c, Random& random) {
  const std::span<const Vec3> points = c.a.vertices();
  if (points.empty() || points.size() > 64) return {};
  const double radius = random.once_in(2) ? 0 : random.unit() * 0.1 * c.unit;
  const Shape all = point_cloud(points, radius), ball(Sphere{radius});
  const PairAnswer r = distance(all, c.pair.a.pose, c.b, c.pair.b.pose);
  double least = infinity, bound = 0;
  bool any = false;
  for (const Vec3& p : points) {
    const Pose at{Mat3::Identity(), c.pair.a.pose * p};
    const PairAnswer one = distance(ball, at, c.b, c.pair.b.pose);
    least = std::min(least, one.signed_distance);
    bound = std::max(bound, one.error_bound);
    any = any || collide(ball, at, c.b, c.pair.b.pose);
  }
  const double tolerance = rounding * c.unit + bound + r.error_bound + 4 * world_rounding(c.pair);
  if (collide(all, c.pair.a.pose, c.b, c.pair.b.pose) != any && std::abs(least) > tolerance)
    return say("a cloud's collide is ", !any, ", the nearest of its balls is ", least, " off");
  if (least > 0 && !(std::abs(r.signed_distance - least) <= tolerance))
    return say("a cloud is ", r.signed_distance, " off, the nearest of its balls ", least);
  if (least < -tolerance && r.signed_distance > least + tolerance)
    return say("a cloud is ", -r.signed_distance, " deep, the deepest of its balls ", -least);
  return {};
}

namespace {

// A solid and the convex solids of which it is the union, in its frame.
struct Union {
  Shape whole;
  std::vector<Shape> parts;
  std::vector<Vec3> places;
};

Union cubes(double size, Random& random) {
  std::vector<std::array<std::int32_t, 3>> cells;
  std::vector<Vec3> places;
  for (int n = 1 + random.below(8); n > 0; --n) {
    const int z = random.below(3) - 1, y = random.below(3) - 1, x = random.below(3) - 1;
    cells.push_back({x, y, z});
    places.push_back(size * (Vec3(x, y, z) + Vec3::Constant(0.5)));
  }
  return {voxel_mesh(cells, size), std::vector<Shape>(cells.size(), Shape(Box{Vec3::Constant(size)})), places};
}

Union land(double size, Random& random) {
  const int columns = 2 + random.below(3), rows = 2 + random.below(3);
  const double bottom = -size * random.unit();
  std::vector<double> heights(static_cast<std::size_t>(columns * rows));
  for (double& h : heights) h = size * (random.once_in(4) ? 0.5 : random.in(0.1, 1));
  Union land{
      height_field(heights, static_cast<std::size_t>(columns), static_cast<std::size_t>(rows), size, bottom), {}, {}};
  const auto at = [&](int i, int j) {
    return Vec3((i - 0.5 * (columns - 1)) * size, (j - 0.5 * (rows - 1)) * size,
                heights[static_cast<std::size_t>(j * columns + i)]);
  };
  for (int i = 0; i + 1 < columns; ++i)
    for (int j = 0; j + 1 < rows; ++j)
      for (const Vec3& beside : {at(i + 1, j), at(i, j + 1)}) {
        Convex prism{{at(i, j), beside, at(i + 1, j + 1)}};
        for (int k = 0; k < 3; ++k) {
          const Vec3 top = prism.vertices[static_cast<std::size_t>(k)];
          prism.vertices.push_back({top.x(), top.y(), bottom});
        }
        land.parts.push_back(Shape(prism));
        land.places.push_back(Vec3::Zero());
      }
  return land;
}

// Two solids of cubes of one grid: the verdict is known exactly, also for touches.
std::string cubes_of_one_grid(Random& random) {
  const double size = std::ldexp(1.0, random.below(21) - 10);
  const Union a = cubes(size, random), b = cubes(size, random);
  const int x = random.below(7) - 3, y = random.below(7) - 3, z = random.below(7) - 3;
  const Vec3 by = size * Vec3(x, y, z);
  bool any = false;
  for (const Vec3& p : a.places)
    for (const Vec3& q : b.places) any = any || (q + by - p).cwiseAbs().maxCoeff() <= size;
  const Pose at{Mat3::Identity(), by};
  if (collide(a.whole, {}, b.whole, at) != any) return say("cubes of one grid: collide is ", !any);
  if (distance(a.whole, {}, b.whole, at).collide != any) return say("cubes of one grid: the distance's is ", !any);
  return {};
}

}  // namespace

// Cubes of a grid, or a height field, in A's place: the union of its cubes, or of its prisms.
std::string unions(const Case& c, Random& random) {
  if (!(c.unit > 0)) return {};
  const double size = random.in(0.05, 0.4) * c.unit;
  const bool by_cubes = random.once_in(2);
  const Union all = by_cubes ? cubes(size, random) : land(size, random);
  const Pose& a = c.pair.a.pose;
  const PairAnswer r = distance(all.whole, a, c.b, c.pair.b.pose);
  double least = infinity, bound = 0;
  bool any = false;
  for (std::size_t k = 0; k < all.parts.size(); ++k) {
    const Pose at{a.rotation, a * all.places[k]};
    const PairAnswer part = distance(all.parts[k], at, c.b, c.pair.b.pose);
    least = std::min(least, part.signed_distance);
    bound = std::max(bound, part.error_bound);
    any = any || collide(all.parts[k], at, c.b, c.pair.b.pose);
  }
  const double tolerance = rounding * (c.unit + all.whole.size()) + bound + 4 * world_rounding(c.pair);
  const char* what = by_cubes ? "cubes" : "land";
  if (collide(all.whole, a, c.b, c.pair.b.pose) != any && std::abs(least) > tolerance)
    return say(what, ": collide is ", !any, ", the nearest of the parts is ", least, " off");
  // A touch on the common boundary of parts may be missed for each part by rounding.
  if (least > tolerance && !(std::abs(r.signed_distance - least) <= tolerance + r.error_bound))
    return say(what, ": ", r.signed_distance, " off, the nearest of the parts ", least);
  if (least <= tolerance && r.signed_distance - r.error_bound > least + tolerance)
    return say(what, ": ", -r.signed_distance, " +- ", r.error_bound, " deep, the deepest of the parts ", -least);
  return random.once_in(4) ? cubes_of_one_grid(random) : std::string();
}

// A mesh deformed into its place answers as the mesh made there.
std::string deformed(const Case& c, Random& random) {
  std::array<std::optional<Shape>, 2> bent;
  for (const bool first : {true, false}) {
    const PosedShape& s = first ? c.pair.a : c.pair.b;
    const Mesh* m = std::get_if<Mesh>(&s.shape);
    if (m == nullptr || m->triangles.size() > 5000) continue;
    Mesh start = *m;
    if (random.once_in(2)) {
      const Vec3 stretch = random.vec(0.5, 2), bend = 0.1 * random.vec(-1, 1);
      for (Vec3& v : start.vertices)
        v = v.cwiseProduct(stretch) + Vec3(bend.x() * v.y(), bend.y() * v.z(), bend.z() * v.x());
    }
    try {
      DeformableMesh mesh(start);
      mesh.update(m->vertices);
      bent[first ? 0 : 1] = mesh.shape();
    } catch (const std::invalid_argument&) {
      return {};  // the deformation separated vertices, or turned the mesh inside out
    }
    if (s.rounding > 0) bent[first ? 0 : 1] = bent[first ? 0 : 1]->rounded(s.rounding);
  }
  if (!bent[0] && !bent[1]) return {};
  const Answers r =
      answer(bent[0] ? *bent[0] : c.a, c.pair.a.pose, bent[1] ? *bent[1] : c.b, c.pair.b.pose, c.pair.margin);
  return difference(c.answers, r, 1, c.unit, false, c.pair.margin);
}

}  // namespace tandem::relations
