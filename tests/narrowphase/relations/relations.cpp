// The relations between answers, one function each, and their list.
#include "relations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "checks.h"
#include "other_calls.h"
#include "shapes/hull.h"
#include "shapes/shape_insides.h"
#include "surface_distance.h"
#include "tandem/narrowphase/several_pairs.h"

namespace tandem::relations {
namespace {

double deepest(std::span<const Contact> contacts) {
  double most = -infinity;
  for (const Contact& c : contacts) most = std::max(most, c.depth);
  return most;
}

}  // namespace

Answers answer(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin) {
  Answers r;
  r.collide = collide(a, pose_a, b, pose_b);
  r.distance = distance(a, pose_a, b, pose_b);
  r.contacts = plain().solve(a, pose_a, b, pose_b, Request::contacts, &r.touching);
  r.near = NarrowPhase({.margin = margin}).solve(a, pose_a, b, pose_b, Request::contacts, &r.within);
  return r;
}

std::string difference(const Answers& x, const Answers& y, double factor, double unit, bool verdicts, double margin) {
  const double tolerance = rounding * unit, d = x.distance.signed_distance;
  // A touch that one call reports, and that the other's error bound does not exclude, is no contradiction.
  const bool may_touch =
      std::abs(d) - x.distance.error_bound <= tolerance && std::abs(y.distance.signed_distance) / factor <= tolerance;
  const bool is_tie = (std::abs(d) <= tolerance || may_touch) && !verdicts;
  if (x.collide != y.collide && !is_tie) return say("collide ", y.collide, " for ", x.collide, " at ", d);
  const auto apart = [&](const PairAnswer& p, const PairAnswer& q) {
    return std::abs(p.signed_distance - q.signed_distance / factor) - (p.error_bound + q.error_bound / factor);
  };
  if (!(apart(x.distance, y.distance) <= tolerance))
    return say("distance ", y.distance.signed_distance / factor, " +- ", y.distance.error_bound / factor, " for ", d,
               " +- ", x.distance.error_bound);
  if (x.touching.empty() != y.touching.empty() && !is_tie)
    return say(y.touching.size(), " contacts for ", x.touching.size(), " at ", d);
  if (!x.touching.empty() && !y.touching.empty() && !(apart(x.contacts, y.contacts) <= tolerance))
    return say("deepest contact ", -y.contacts.signed_distance / factor, " +- ", y.contacts.error_bound / factor,
               " for ", -x.contacts.signed_distance, " +- ", x.contacts.error_bound);
  const bool at_margin = std::abs(d - margin) <= tolerance && !verdicts;
  if (x.within.empty() != y.within.empty() && !at_margin)
    return say(y.within.size(), " contacts within the margin for ", x.within.size(), " at ", d);
  if (!x.within.empty() && !y.within.empty() && !(apart(x.near, y.near) <= tolerance))
    return say("deepest contact within the margin ", -y.near.signed_distance / factor, " for ",
               -x.near.signed_distance);
  if (!verdicts) return {};
  for (const auto& [p, q] : {std::pair(&x.touching, &y.touching), std::pair(&x.within, &y.within)})
    if (!std::equal(p->begin(), p->end(), q->begin(), q->end(),
                    [](const Contact& c, const Contact& e) { return c.feature == e.feature; }))
      return say("other contacts: ", q->size(), " for ", p->size());
  return {};
}

namespace {

std::string same(const Case& c, const PosedPair& other, double factor = 1, bool verdicts = false) {
  return difference(c.answers, answer(other), factor, c.unit, verdicts, c.pair.margin);
}

// One of two shapes in another representation: the other's hull or hierarchy need not be built again.
std::string same_but_one(const Case& c, const PosedPair& other, bool first) {
  const Shape changed = make_shape(first ? other.a : other.b);
  const Answers r = answer(first ? changed : c.a, other.a.pose, first ? c.b : changed, other.b.pose, other.margin);
  return difference(c.answers, r, 1, c.unit, false, c.pair.margin);
}

// The same shapes at other poses.
std::string same_shapes(const Case& c, const PosedPair& other, bool verdicts) {
  return difference(c.answers, answer(c.a, other.a.pose, c.b, other.b.pose, other.margin), 1, c.unit, verdicts,
                    c.pair.margin);
}

// ---- One pair, several requests ----

// The error bound goes with the status: an ok answer is right to `surface`.
bool all_finite(const PairAnswer& r, double unit) {
  return std::isfinite(r.signed_distance) && r.normal.allFinite() && r.point_a.allFinite() && r.point_b.allFinite() &&
         std::isfinite(r.error_bound) && r.error_bound >= 0 &&
         (r.status == Status::ok ? r.error_bound <= surface * unit : r.error_bound > 0);
}

// A cut-off does not change an answer within it; pairs without an answer are farther.
std::string cutoffs(const Case& c, Random& random) {
  const PairAnswer& full = c.answers.distance;
  const double d = full.signed_distance, tolerance = rounding * c.unit;
  for (const double cutoff : {0.0, random.unit() * std::abs(d), std::abs(d), 2 * std::abs(d), 0.01 * c.unit}) {
    const PairAnswer r = plain().distance_within(c.a, c.pair.a.pose, c.b, c.pair.b.pose, cutoff),
                     option = NarrowPhase({.cutoff = cutoff})
                                  .solve(c.a, c.pair.a.pose, c.b, c.pair.b.pose, Request::distance);
    if (r.farther != option.farther || r.signed_distance != option.signed_distance)
      return say("cut-off ", cutoff, " as an argument: ", r.signed_distance,
                 ", as an option: ", option.signed_distance);
    if (r.farther != (d > cutoff) && std::abs(d - cutoff) > tolerance + full.error_bound)
      return say(r.farther ? "farther" : "not farther", " than ", cutoff, " at ", d);
    if (r.farther ? r.collide || r.signed_distance != cutoff : r.collide != full.collide)
      return say("collide ", r.collide, " with the cut-off ", cutoff, " at ", d);
    if (!r.farther && !(std::abs(r.signed_distance - d) <= tolerance + r.error_bound + full.error_bound))
      return say("distance ", r.signed_distance, " with the cut-off ", cutoff, ", ", d, " without");
  }
  return {};
}

// Rounding two shapes reduces their distance by the radii.
std::string rounded(const Case& c, Random&) {
  PosedPair cores = c.pair;
  cores.a.rounding = cores.b.rounding = 0;
  const bool has_mesh = !c.a.is_convex() || !c.b.is_convex();
  const PairAnswer r = distance(make_shape(cores.a), cores.a.pose, make_shape(cores.b), cores.b.pose);
  if (has_mesh && r.signed_distance <= 0) return {};  // a ball may leave a mesh by another translation than its centre
  const PairAnswer& full = c.answers.distance;
  const double expected = r.signed_distance - c.pair.a.rounding - c.pair.b.rounding;
  if (has_mesh && expected < 0) {
    if (!c.answers.collide && expected < -rounding * c.unit)
      return say("no collision, cores ", r.signed_distance, " apart");
    return {};
  }
  if (!(std::abs(full.signed_distance - expected) <= rounding * c.unit + full.error_bound + r.error_bound))
    return say("distance ", full.signed_distance, ", of the cores less the radii ", expected);
  return {};
}

std::string numbers(const Case& c, Random&) {
  const Answers& r = c.answers;
  const double unit = std::max(c.unit, c.a.size() + c.b.size());  // the status is relative to the sizes
  for (const PairAnswer* some : {&r.distance, &r.contacts, &r.near})
    if (!all_finite(*some, unit)) return say("not finite, or an error bound without its status");
  if (!(std::abs(r.distance.normal.norm() - 1) < 1e-14)) return say("normal of length ", r.distance.normal.norm());
  for (const auto* list : {&r.touching, &r.within})
    for (const Contact& contact : *list)
      if (!contact.point.allFinite() || !std::isfinite(contact.depth) || !(std::abs(contact.normal.norm() - 1) < 1e-14))
        return say("a contact is not finite");
  return {};
}

std::string verdicts(const Case& c, Random&) {
  const Answers& r = c.answers;
  const double d = r.distance.signed_distance;
  if (r.collide != (d <= 0)) return say("collide ", r.collide, ", distance ", d);
  if (r.collide != r.distance.collide) return say("collide ", r.collide, ", of the distance ", r.distance.collide);
  if (r.collide != r.contacts.collide) return say("collide ", r.collide, ", of the contacts ", r.contacts.collide);
  if (r.collide != !r.touching.empty()) return say("collide ", r.collide, ", contacts ", r.touching.size());
  if (r.collide != r.near.collide)
    return say("collide ", r.collide, ", of the contacts with a margin ", r.near.collide);
  return {};
}

// The deepest contact is the distance's depth, and no other is deeper.
std::string contact_depths(const Case& c, Random&) {
  const Answers& r = c.answers;
  if (r.touching.empty()) return {};
  const double most = deepest(r.touching), tolerance = rounding * c.unit;
  if (!(std::abs(most + r.contacts.signed_distance) <= tolerance))
    return say("deepest contact ", most, ", answer ", -r.contacts.signed_distance);
  if (const double bounds = r.contacts.error_bound + r.distance.error_bound;
      !(std::abs(most + r.distance.signed_distance) <= bounds + tolerance))
    return say("deepest contact ", most, " +- ", r.contacts.error_bound, ", depth ", -r.distance.signed_distance,
               " +- ", r.distance.error_bound);
  return {};
}

std::string margins(const Case& c, Random&) {
  const Answers& r = c.answers;
  const double d = r.distance.signed_distance, tolerance = rounding * c.unit, m = c.pair.margin;
  if (r.within.empty() != (d > m) && std::abs(d - m) > tolerance + r.distance.error_bound)
    return say(r.within.size(), " contacts within ", m, " at ", d);
  if (r.within.empty()) return {};
  const double most = deepest(r.within);
  for (const Contact& contact : r.within)
    if (contact.depth < -m - tolerance) return say("a contact ", contact.depth, " beyond the margin ", m);
  if (d > 0 && !(most < 0)) return say("a contact as deep as ", most, " of shapes that are ", d, " apart");
  if (const double bounds = r.near.error_bound + r.distance.error_bound; !(std::abs(most + d) <= bounds + tolerance))
    return say("deepest contact ", most, " +- ", r.near.error_bound, " for a distance of ", d, " +- ",
               r.distance.error_bound);
  return {};
}

// The verdict with B moved, relative to A's translation: far from the origin B's coordinates would be rounded.
bool collide_moved(const Case& c, const Vec3& by) {
  const Pose &a = c.pair.a.pose, &b = c.pair.b.pose;
  return collide(c.a, {a.rotation, Vec3::Zero()}, c.b, {b.rotation, b.translation - a.translation + by});
}

// True if B, moved by a length along n, leaves A to within `slack`: moved farther by less than that, it may touch the
// next part of A, as the other side of a notch.
bool separates(const Case& c, double length, const Vec3& n, double slack) {
  const Pose &a = c.pair.a.pose, &b = c.pair.b.pose;
  for (const double farther : {slack, slack / 2, slack / 4, slack / 8, 0.0})
    if (!collide_moved(c, (length + farther) * n)) return true;
  const PairAnswer r = distance(c.a, {a.rotation, Vec3::Zero()}, c.b,
                                {b.rotation, b.translation - a.translation + (length + slack) * n});
  return -r.signed_distance - r.error_bound <= slack;
}

std::string translation_out(const Case& c, Random&) {
  const PairAnswer& r = c.answers.distance;
  const double d = r.signed_distance;
  if (!(c.unit > 0)) return {};  // two points at one place: no length to move by
  const auto moved = [&](double by) { return collide_moved(c, by * r.normal); };
  const double slack = 2 * rounding * c.unit;
  if (d > 0) {
    if (moved(-(d - r.error_bound - slack)) && d - r.error_bound > 2 * slack)
      return say("they collide before the gap ", d, " is closed");
    return {};
  }
  // They may still touch, along a face on which B slides.
  if (!separates(c, -d, r.normal, slack))
    return say("moving by the depth ", -d, " (", r.error_bound, ") does not separate");
  if (r.status == Status::ok && -d > 100 * slack && !moved(-0.99 * d))
    return say("moving by 0.99 of the depth ", -d, " separates");
  return {};
}

std::string deepest_contact_separates(const Case& c, Random&) {
  const Answers& r = c.answers;
  if (r.touching.empty() || r.contacts.status != Status::ok || !(c.unit > 0)) return {};
  const auto at = std::max_element(r.touching.begin(), r.touching.end(),
                                   [](const Contact& x, const Contact& y) { return x.depth < y.depth; });
  const double slack = 2 * rounding * c.unit;
  if (separates(c, at->depth, at->normal, slack)) return {};
  return say("moving by the deepest contact, ", at->depth, ", does not separate");
}

std::string witnesses(const Case& c, Random&) {
  const PairAnswer& r = c.answers.distance;
  const bool has_mesh = !c.a.is_convex() || !c.b.is_convex();
  if (r.status != Status::ok || (has_mesh && r.signed_distance <= 0)) return {};
  const double tolerance = surface * c.unit + 4 * world_rounding(c.pair);
  if (const double off = (r.point_b - r.point_a - r.signed_distance * r.normal).norm(); !(off <= tolerance))
    return say("the points are off by ", off, " from distance x normal");
  if (const double off = surface_distance(c.pair.a, c.a, r.point_a); !(off <= tolerance))
    return say("point_a is off A's surface by ", off);
  if (const double off = surface_distance(c.pair.b, c.b, r.point_b); !(off <= tolerance))
    return say("point_b is off B's surface by ", off);
  return {};
}

std::string warm_starts(const Case& c, Random& random) {
  for (const double length : {1.0, 1e-300, 1e200}) {
    WarmStart warm{length * random.direction()};
    Answers r = c.answers;
    r.touching.clear();
    const auto solve = [&](Request request, std::vector<Contact>* contacts) {
      WarmStart used = warm;
      return plain().solve(c.a, c.pair.a.pose, c.b, c.pair.b.pose, request, contacts, &used);
    };
    r.collide = solve(Request::collide, nullptr).collide;
    r.distance = solve(Request::distance, nullptr);
    r.contacts = solve(Request::contacts, &r.touching);
    if (std::string why = difference(c.answers, r, 1, c.unit, false, c.pair.margin); !why.empty()) return why;
  }
  return {};
}

class FirstAnswer final : public AnswerSink {
 public:
  PairAnswer& begin(std::size_t) override {
    given = true;
    return answer;
  }
  void end() override {}
  PairAnswer answer;
  bool given = false;
};

std::string several_within(const Case& c, double margin, const std::vector<Contact>& alone, const PairAnswer& answer) {
  const PlacedPair pair{&c.a, &c.pair.a.pose, &c.b, &c.pair.b.pose};
  std::vector<Contact> contacts;
  FirstAnswer sink;
  SeveralPairs({.margin = margin}).solve(std::span(&pair, 1), contacts, sink);
  const auto same_bits = [](const Contact& x, const Contact& y) {
    return x.point == y.point && x.normal == y.normal && x.depth == y.depth && x.feature == y.feature;
  };
  if (!std::equal(contacts.begin(), contacts.end(), alone.begin(), alone.end(), same_bits))
    return say("several at once: other contacts, ", contacts.size(), " for ", alone.size());
  if (sink.given && sink.answer.signed_distance != answer.signed_distance)
    return say("several at once: another distance");
  std::uint8_t apart = 0;
  NarrowPhase({.margin = margin}).mark_apart(std::span(&pair, 1), std::span(&apart, 1));
  if (apart != 0 && !alone.empty()) return say("marked as apart with contacts within the margin");
  return {};
}

std::string several(const Case& c, Random&) {
  const Answers& r = c.answers;
  if (std::string why = several_within(c, 0, r.touching, r.contacts); !why.empty()) return why;
  return several_within(c, c.pair.margin, r.within, r.near);
}

std::string impact(const Case& c, Random& random) {
  const double d = c.answers.distance.signed_distance, tolerance = 10 * rounding * c.unit + world_rounding(c.pair);
  const double path = random.in(0.2, 3) * (std::abs(d) + 0.1 * c.unit);
  const Vec3 aside = random.direction();
  const Vec3 velocity = -path * (c.answers.distance.normal + random.in(0, 1) * aside);
  const auto t = plain().time_of_impact(c.a, c.pair.a.pose, Vec3::Zero(), c.b, c.pair.b.pose, velocity, 1);
  const auto at = [&](double time) {
    Pose pose = c.pair.b.pose;
    pose.translation += time * velocity;
    return distance(c.a, c.pair.a.pose, c.b, pose);
  };
  const auto overlaps = [&](const PairAnswer& r) { return r.signed_distance + r.error_bound < -tolerance; };
  if (c.answers.collide) return t == 0.0 ? std::string() : say("an impact later than 0 of shapes that collide");
  const double end = t.value_or(1);
  constexpr int samples = 8;
  for (int k = 0; k < samples; ++k)
    if (const PairAnswer there = at(end * k / samples); overlaps(there))
      return say("they overlap by ", -there.signed_distance, " at ", end * k / samples, " before the impact at ", end);
  if (!t) {
    if (const PairAnswer there = at(1); overlaps(there))
      return say("no impact, and they overlap by ", -there.signed_distance, " at the end");
    return {};
  }
  if (const PairAnswer there = at(*t); overlaps(there) || there.signed_distance > tolerance + early * path)
    return say("a distance of ", there.signed_distance, " at the impact");
  return {};
}

// ---- The same real numbers in other representations ----

std::string swap(const Case& c, Random&) {
  const Answers r = answer(c.b, c.pair.b.pose, c.a, c.pair.a.pose, c.pair.margin);
  return difference(c.answers, r, 1, c.unit, false, c.pair.margin);
}

std::string scaled(const Case& c, Random& random) {
  for (int tries = 0; tries < 4; ++tries) {
    const double factor = std::ldexp(1.0, random.below(181) - 90);
    if (!can_scale(c.pair, factor)) continue;
    PosedPair other = c.pair;
    scale(other, factor);
    if (std::string why = same(c, other, factor, true); !why.empty()) return say("times ", factor, ": ", why);
    return {};
  }
  return {};
}

// Takes axes to axes: exact.
std::string turned(const Case& c, Random& random) {
  Mat3 turn = Mat3::Zero();
  const int first = random.below(3), second = (first + 1 + random.below(2)) % 3;
  turn(first, 0) = random.sign(), turn(second, 1) = random.sign(), turn(3 - first - second, 2) = 1;
  if (turn.determinant() < 0) turn(3 - first - second, 2) = -1;
  PosedPair other = c.pair;
  for (PosedShape* s : {&other.a, &other.b}) s->pose = {turn * s->pose.rotation, turn * s->pose.translation};
  return same_shapes(c, other, false);
}

std::string moved(const Case& c, Random& random) {
  const int z = random.below(2049) - 1024, y = random.below(2049) - 1024, x = random.below(2049) - 1024;
  const Vec3 move(x, y, z);
  PosedPair other = c.pair;
  for (PosedShape* s : {&other.a, &other.b}) {
    const Vec3 to = s->pose.translation + move;
    if (to - move != s->pose.translation || to - s->pose.translation != move) return {};
    s->pose.translation = to;
  }
  return same_shapes(c, other, true);
}

template <class T>
void shuffle(std::vector<T>& list, Random& random) {
  for (std::size_t i = list.size(); i > 1; --i)
    std::swap(list[i - 1], list[static_cast<std::size_t>(random.below(static_cast<int>(i)))]);
}

// False if the kind has no vertices.
bool permute(ShapeData& data, Random& random) {
  if (auto* hull = std::get_if<Convex>(&data)) shuffle(hull->vertices, random);
  if (auto* triangle = std::get_if<Triangle>(&data))
    std::swap(triangle->vertices[0], triangle->vertices[random.below(2) == 0 ? 1 : 2]);
  if (auto* mesh = std::get_if<Mesh>(&data)) {
    std::vector<std::uint32_t> place(mesh->vertices.size());
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<std::uint32_t>(i);
    shuffle(place, random);
    std::vector<Vec3> vertices(mesh->vertices.size());
    for (std::size_t i = 0; i < place.size(); ++i) vertices[place[i]] = mesh->vertices[i];
    mesh->vertices = vertices;
    shuffle(mesh->triangles, random);
    for (auto& t : mesh->triangles) {
      for (auto& v : t) v = place[v];
      std::rotate(t.begin(), t.begin() + random.below(3), t.end());
    }
  }
  return std::holds_alternative<Convex>(data) || std::holds_alternative<Triangle>(data) ||
         std::holds_alternative<Mesh>(data);
}

std::string permuted(const Case& c, Random& random) {
  PosedPair other = c.pair;
  const bool a = permute(other.a.shape, random), b = permute(other.b.shape, random);
  return a && b ? same(c, other) : same_but_one(c, other, a);
}

Mesh single(const std::array<Vec3, 3>& p) { return {{p[0], p[1], p[2]}, {{0, 1, 2}}, false}; }

Mesh box_mesh(const Vec3& size) {
  Mesh m;
  m.solid = true;
  for (int i = 0; i < 8; ++i)
    m.vertices.push_back(0.5 * size.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

struct OtherKind {
  ShapeData shape;
  double rounding = 0;  // beside that of the shape
};

// The faces of a hull that has a volume, cut into triangles; else none.
Mesh hull_mesh(const Convex& convex) {
  const Shape shape(convex);
  const Hull& h = hull_of(shape);
  Mesh m;
  if (h.dimension < 3) return m;
  m.solid = true;
  m.vertices = h.vertices;
  for (const Hull::Face& f : h.faces)
    for (std::uint32_t k = 1; k + 1 < f.count; ++k)
      m.triangles.push_back({h.loop[f.first], h.loop[f.first + k], h.loop[f.first + k + 1]});
  return m;
}

// The same hull, given with points inside it.
Convex with_midpoints(Convex convex) {
  const std::size_t count = convex.vertices.size();
  for (std::size_t i = 0; i < count; ++i)
    convex.vertices.push_back((convex.vertices[i] + convex.vertices[(i + 1) % count]) / 2);
  return convex;
}

// Every triangle with separate vertices.
Mesh unshared(const Mesh& mesh) {
  Mesh m;
  m.solid = mesh.solid;
  for (const auto& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(m.vertices.size());
    for (const std::uint32_t v : t) m.vertices.push_back(mesh.vertices[v]);
    m.triangles.push_back({first, first + 1, first + 2});
  }
  return m;
}

// Every triangle twice, once from either side.
Mesh both_sides(Mesh mesh) {
  const std::size_t count = mesh.triangles.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = mesh.triangles[i];
    mesh.triangles.push_back({t[0], t[2], t[1]});
  }
  return mesh;
}

bool is_convex(const Mesh& mesh) {
  const double own = Shape(mesh).mass().volume, hull = Shape(Convex{mesh.vertices}).mass().volume;
  return std::abs(hull - own) <= 1e-14 * hull;
}

// The other kinds that are the same solid.
std::vector<OtherKind> other_kinds(const ShapeData& data) {
  std::vector<OtherKind> others;
  if (const auto* s = std::get_if<Sphere>(&data); s != nullptr && s->radius > 0) {
    others.push_back({Ellipsoid{Vec3::Constant(s->radius)}});
    others.push_back({Capsule{s->radius, 0}});
    others.push_back({Convex{{Vec3::Zero()}}, s->radius});
  }
  if (const auto* s = std::get_if<Box>(&data)) {
    const Mesh m = box_mesh(s->size);
    others.push_back({Convex{m.vertices}});
    others.push_back({m});
  }
  if (const auto* s = std::get_if<Triangle>(&data)) {
    others.push_back({Convex{{s->vertices.begin(), s->vertices.end()}}});
    others.push_back({single(s->vertices)});
  }
  if (const auto* s = std::get_if<Capsule>(&data))
    others.push_back({Convex{{Vec3(0, 0, -s->length / 2), Vec3(0, 0, s->length / 2)}}, s->radius});
  if (const auto* s = std::get_if<Ellipsoid>(&data); s != nullptr && s->radii == Vec3::Constant(s->radii[0]))
    others.push_back({Sphere{s->radii[0]}});
  if (const auto* s = std::get_if<Convex>(&data)) {
    others.push_back({with_midpoints(*s)});
    if (const Mesh m = hull_mesh(*s); !m.triangles.empty()) others.push_back({m});
  }
  if (const auto* s = std::get_if<Mesh>(&data); s != nullptr && s->triangles.size() <= 512) {
    others.push_back({unshared(*s)});
    if (!s->solid) others.push_back({both_sides(*s)});
    if (s->solid && is_convex(*s)) others.push_back({Convex{s->vertices}});
  }
  return others;
}

std::string other_kind(const Case& c, Random&) {
  for (const bool first : {true, false})
    for (const OtherKind& kind : other_kinds((first ? c.pair.a : c.pair.b).shape)) {
      PosedPair other = c.pair;
      PosedShape& changed = first ? other.a : other.b;
      changed.shape = kind.shape;
      changed.rounding += kind.rounding;
      if (std::string why = same_but_one(c, other, first); !why.empty())
        return say(first ? "A" : "B", " as ", name(changed.kind()), kind.rounding > 0 ? ", rounded: " : ": ", why);
    }
  return {};
}

// True for a triangle or a surface, and for a body less than `gap` wide.
bool is_thin(const Shape& s, double gap) {
  if (!s.is_solid()) return true;
  if (s.kind() != ShapeKind::convex) return s.is_bounded() && s.mass().volume <= gap * s.size() * s.size();
  const std::span<const Vec3> points = s.vertices();
  Vec3 along = Vec3::Zero(), across = Vec3::Zero();
  for (const Vec3& p : points)
    if ((p - points[0]).squaredNorm() > along.squaredNorm()) along = p - points[0];
  for (const Vec3& p : points)
    if (const Vec3 n = along.cross(p - points[0]); n.squaredNorm() > across.squaredNorm()) across = n;
  const bool is_rod = across.norm() <= gap * along.norm();
  return is_rod || std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
           return std::abs(across.dot(p - points[0])) <= gap * across.norm();
         });
}

// Surfaces whose triangles have separate vertices that differ by rounding. A body without thickness may fit exactly
// between two of them; then it does not where it is a little aside.
std::string seams(const Case& c, Random& random) {
  for (const bool first : {true, false}) {
    PosedPair other = c.pair;
    Mesh* const mesh = std::get_if<Mesh>(&(first ? other.a : other.b).shape);
    if (mesh == nullptr || mesh->solid || mesh->triangles.size() > 512) continue;
    const double most = reach(*mesh) * std::numeric_limits<double>::epsilon();
    *mesh = unshared(*mesh);
    for (Vec3& v : mesh->vertices) v += random.vec(-most, most);
    const Shape changed = make_shape(first ? other.a : other.b);
    const Shape &a = first ? changed : c.a, &b = first ? c.b : changed;
    const Pose& at_a = c.pair.a.pose;
    const auto differ = [&](const Pose& at_b, const Answers& whole) {
      return difference(whole, answer(a, at_a, b, at_b, c.pair.margin), 1, c.unit, false, c.pair.margin);
    };
    const std::string why = differ(c.pair.b.pose, c.answers);
    if (why.empty()) continue;
    Pose aside = c.pair.b.pose;
    aside.translation += 64 * most * Vec3(3, 5, 7);
    if (is_thin(first ? c.b : c.a, 64 * most) && differ(aside, answer(c.a, at_a, c.b, aside, c.pair.margin)).empty())
      continue;
    return say("the triangles of ", first ? "A" : "B", " apart by rounding: ", why);
  }
  return {};
}

// Hulls of `sides` points a circle that lie in a cylinder or cone, or around it.
Convex prism(double radius, double length, bool is_cone, bool around) {
  constexpr int sides = 16;
  const double step = 2 * std::numbers::pi / sides,
               r = around ? radius / std::cos(step / 2) * (1 + 1e-15) : radius * (1 - 1e-15);
  Convex c;
  for (int i = 0; i < sides; ++i) {
    c.vertices.emplace_back(r * std::cos(i * step), r * std::sin(i * step), -length / 2);
    if (!is_cone) c.vertices.emplace_back(r * std::cos(i * step), r * std::sin(i * step), length / 2);
  }
  if (is_cone) c.vertices.emplace_back(0, 0, length / 2);
  return c;
}

// Solids inside and around a round one.
std::vector<std::array<ShapeData, 2>> brackets(const ShapeData& data) {
  std::vector<std::array<ShapeData, 2>> some;
  if (const auto* s = std::get_if<Cylinder>(&data)) {
    some.push_back({prism(s->radius, s->length, false, false), prism(s->radius, s->length, false, true)});
    if (s->length > 2 * s->radius)
      some.push_back({Capsule{s->radius, s->length - 2 * s->radius}, Capsule{s->radius, s->length}});
  }
  if (const auto* s = std::get_if<Cone>(&data))
    some.push_back({prism(s->radius, s->length, true, false), prism(s->radius, s->length, true, true)});
  return some;
}

std::string bracketed(const Case& c, Random&) {
  const double d = c.answers.distance.signed_distance, error = c.answers.distance.error_bound;
  for (const bool first : {true, false})
    for (const auto& bracket : brackets((first ? c.pair.a : c.pair.b).shape))
      for (const bool around : {false, true}) {
        PosedShape other = first ? c.pair.a : c.pair.b;
        other.shape = bracket[around ? 1 : 0];
        const Shape changed = make_shape(other);
        const PairAnswer r = distance(first ? changed : c.a, c.pair.a.pose, first ? c.b : changed, c.pair.b.pose);
        const double beyond = around ? r.signed_distance - d : d - r.signed_distance;
        if (beyond > rounding * c.unit + error + r.error_bound)
          return say("distance ", d, ", but ", r.signed_distance, " of the ",
                     name(static_cast<ShapeKind>(bracket[0].index())), around ? " around " : " inside ",
                     first ? "A" : "B");
      }
  return {};
}

// Each triangle as four, where midpoints are exact; false where they are not.
bool subdivide(Mesh& m) {
  if (m.triangles.size() > 512) return false;
  std::vector<std::array<std::uint32_t, 3>> fine;
  for (const auto& t : m.triangles) {
    std::array<std::uint32_t, 3> middle;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &p = m.vertices[t[k]], &q = m.vertices[t[(k + 1) % 3]];
      const Vec3 sum = p + q;
      if (sum - q != p || sum - p != q) return false;
      middle[k] = static_cast<std::uint32_t>(m.vertices.size());
      m.vertices.push_back(sum / 2);
    }
    fine.push_back({t[0], middle[0], middle[2]});
    fine.push_back({t[1], middle[1], middle[0]});
    fine.push_back({t[2], middle[2], middle[1]});
    fine.push_back({middle[0], middle[1], middle[2]});
  }
  m.triangles = fine;
  return true;
}

std::string subdivided(const Case& c, Random&) {
  PosedPair other = c.pair;
  bool any = false;
  for (PosedShape* s : {&other.a, &other.b})
    if (Mesh* mesh = std::get_if<Mesh>(&s->shape)) {
      Mesh fine = *mesh;
      if (subdivide(fine)) *mesh = fine, any = true;
    }
  return any ? same(c, other) : std::string();
}

// ---- Meshes by their triangles ----

std::vector<Shape> triangles(const PosedShape& posed) {
  std::vector<Shape> all;
  const auto add = [&](const Triangle& t) { all.push_back(make_shape({t, {}, posed.rounding})); };
  if (const auto* t = std::get_if<Triangle>(&posed.shape)) add(*t);
  if (const auto* m = std::get_if<Mesh>(&posed.shape))
    for (const auto& t : m->triangles) add({{m->vertices[t[0]], m->vertices[t[1]], m->vertices[t[2]]}});
  return all;
}

// True if a vertex of the other shape, else its middle, is inside a solid mesh, by the winding number.
bool holds(const PosedShape& outer, const PosedShape& inner) {
  const Mesh* m = std::get_if<Mesh>(&outer.shape);
  if (m == nullptr || !m->solid) return false;
  std::vector<Vec3> points{Vec3::Zero()};
  if (inner.kind() == ShapeKind::halfspace || inner.kind() == ShapeKind::plane) points.clear();
  // Of several, as one may lie on the surface.
  if (const auto* s = std::get_if<Convex>(&inner.shape)) points = {s->vertices.front(), s->vertices.back()};
  if (const auto* s = std::get_if<Triangle>(&inner.shape)) points = {s->vertices.begin(), s->vertices.end()};
  if (const auto* s = std::get_if<Mesh>(&inner.shape)) points = s->vertices;
  if (const auto* s = std::get_if<Voxels>(&inner.shape)) {
    points.clear();
    for (const auto& [corner, level] : s->cells)
      points.push_back(s->origin + s->cell_size * (Vec3(corner[0], corner[1], corner[2]) +
                                                   Vec3::Constant(0.5 * static_cast<double>(1 << level))));
  }
  // More digits than the bodies have: within 1e-13 of an edge both of its triangles take half a turn, or rounding.
  using Long = Eigen::Matrix<long double, 3, 1>;
  const auto to_long = [](const auto& x) { return x.template cast<long double>().eval(); };
  return std::any_of(points.begin(), points.end(), [&](const Vec3& p) {
    const Long at = to_long(outer.pose.rotation).transpose() *
                    (to_long(inner.pose.rotation) * to_long(p) +
                     (to_long(inner.pose.translation) - to_long(outer.pose.translation)));
    long double angle = 0;
    for (const auto& t : m->triangles) {
      const Long a = to_long(m->vertices[t[0]]) - at, b = to_long(m->vertices[t[1]]) - at,
                 e = to_long(m->vertices[t[2]]) - at;
      const long double la = a.norm(), lb = b.norm(), le = e.norm(), volume = a.dot(b.cross(e));
      // The solid angle of a sliver near the point is a rounding error with either sign: half a turn either way.
      if (std::abs(volume) <= 16 * std::numeric_limits<long double>::epsilon() * la * lb * le) continue;
      angle += 2 * std::atan2(volume, la * lb * le + a.dot(b) * le + b.dot(e) * la + e.dot(a) * lb);
    }
    return std::abs(angle) > 2 * std::numbers::pi;
  });
}

std::string by_triangles(const Case& c, Random&) {
  const PosedPair& p = c.pair;
  std::vector<Shape> of_a = triangles(p.a), of_b = triangles(p.b);
  if (of_a.empty()) of_a.push_back(c.a);
  if (of_b.empty()) of_b.push_back(c.b);
  constexpr std::size_t most = 1024;
  if (of_a.size() * of_b.size() > most) return {};
  bool any = false;
  double least = infinity, certain = infinity;  // upper and lower bound on the distance of the nearest
  for (const Shape& s : of_a)
    for (const Shape& t : of_b) {
      const PairAnswer r = distance(s, p.a.pose, t, p.b.pose);
      least = std::min(least, r.signed_distance + r.error_bound);
      certain = std::min(certain, r.signed_distance - r.error_bound);
      any = any || collide(s, p.a.pose, t, p.b.pose);
    }
  const double d = c.answers.distance.signed_distance, tolerance = rounding * c.unit + c.answers.distance.error_bound;
  const bool inside = !any && (holds(p.a, p.b) || holds(p.b, p.a));
  // A touch within the bounds of the nearest triangles may count as either.
  if (c.answers.collide != (any || inside) && (certain > tolerance || least < -tolerance))
    return say("collide ", c.answers.collide, ", of the triangles ", any, ", one inside the other ", inside, " at ",
               certain, " to ", least);
  // One that hardly touches two triangles may be deep across their common edge.
  const bool touch = certain <= tolerance;
  if (!any && !inside && !((touch || d >= certain - tolerance) && d <= least + tolerance))
    return say("distance ", d, ", of the triangles ", certain, " to ", least);
  return {};
}

std::string triangle_list(const Case& c, Random&) {
  const auto list = plain().intersecting_triangles(c.a, c.pair.a.pose, c.b, c.pair.b.pose);
  if (!list.empty() && !c.answers.collide) return say(list.size(), " pairs of triangles intersect, collide is false");
  const auto is_solid = [](const PosedShape& s) {
    const Mesh* m = std::get_if<Mesh>(&s.shape);
    return m != nullptr && m->solid;
  };
  if (list.empty() && c.answers.collide && !is_solid(c.pair.a) && !is_solid(c.pair.b))
    return say("collide, and no pair of triangles intersects, at ", c.answers.distance.signed_distance);
  return {};
}

// ---- The pairs to which a relation applies

bool any(const PosedPair&) { return true; }

template <class... Kinds>
bool has(const PosedPair& p) {
  return ((std::holds_alternative<Kinds>(p.a.shape) || std::holds_alternative<Kinds>(p.b.shape)) || ...);
}

bool has_rounding(const PosedPair& p) { return p.a.rounding + p.b.rounding > 0; }

bool has_triangles_only(const PosedPair& p) {
  const auto is_triangular = [](const PosedShape& s) {
    return s.kind() == ShapeKind::mesh || s.kind() == ShapeKind::triangle;
  };
  return is_triangular(p.a) && is_triangular(p.b) && !has_rounding(p);  // there are no lists for rounded shapes
}

constexpr std::array table{
    Relation{"numbers", "every number is finite, normals are unit, a bound goes with its status", any, numbers},
    Relation{"verdicts", "collide is the sign of the distance, and contacts are there where it is true", any, verdicts},
    Relation{"contact-depths", "the deepest contact is the depth", any, contact_depths},
    Relation{"margins", "contacts within a margin are there where the gap is, as deep as it", any, margins},
    Relation{"cutoffs", "what is within a cut-off has the same distance, what is not is farther", any, cutoffs},
    Relation{"translation-out", "moving by the depth separates, by 0.99 of it does not; closing the gap touches", any,
             translation_out},
    Relation{"contact-separates", "moving by the deepest contact separates where its status is ok", any,
             deepest_contact_separates},
    Relation{"witnesses", "witness points lie on the surfaces, distance x normal apart", any, witnesses},
    Relation{"warm-starts", "any warm start gives the same answers", any, warm_starts},
    Relation{"several", "SeveralPairs gives the same bits, mark_apart is never wrong", any, several},
    Relation{"impact", "no overlap before the time of impact, a touch at it", any, impact},
    Relation{"swap", "exchanging A and B exchanges the answers", any, swap},
    Relation{"scale", "lengths times 2^k give answers times 2^k, the same verdict and features", any, scaled},
    Relation{"turn", "a rotation that takes axes to axes changes nothing", any, turned},
    Relation{"move", "a translation without rounding changes no bit of what it does not move", any, moved},
    Relation{"permute", "the order of vertices, triangles and corners changes nothing", has<Convex, Triangle, Mesh>,
             permuted},
    Relation{"other-kind", "one solid as several kinds has one answer",
             has<Sphere, Capsule, Box, Triangle, Ellipsoid, Convex, Mesh>, other_kind},
    Relation{"seams", "separate vertices of a surface's triangles that differ by rounding change nothing beyond that",
             has<Mesh>, seams},
    Relation{"bracket", "a cylinder or cone lies between solids inside and around it", has<Cylinder, Cone>, bracketed},
    Relation{"subdivide", "cutting triangles at exact midpoints changes nothing", has<Mesh>, subdivided},
    Relation{"by-triangles", "a mesh is its triangles, and its inside where it is solid", has<Mesh>, by_triangles},
    Relation{"triangle-list", "triangles intersect where the meshes collide", has_triangles_only, triangle_list},
    Relation{"motions", "no overlap before the first touch of screws, a touch at it, exchanged the same", any, motions},
    Relation{"contact-points", "a contact's point is within half its depth of both bodies", any, contact_points},
    Relation{"planes", "convex bodies lie behind the planes through their witness points", any, planes},
    Relation{"along", "the separation along a direction is no shorter than the depth, and separates", any, along},
    Relation{"least-depth", "no translation found by trial is shorter than the depth", any, least_depth},
    Relation{"options", "another solver, a tolerance, other parts: the same within what was asked for", any, options},
    Relation{"lanes", "several pairs side by side have the bits they have alone", any, lanes},
    Relation{"scene", "a scene of one body answers as the pair", any, scene},
    Relation{"near-triangles", "pairs of triangles and features within a clearance: the nearest is the distance",
             has_triangles_only, near_triangles},
    Relation{"triangle-places", "the triangles of witness points lie there", has<Mesh>, triangle_places},
    Relation{"cloud", "a cloud of points is as near as the nearest of its balls", has<Convex, Triangle, Mesh>, cloud},
    Relation{"unions", "cubes of a grid are their union, and land is that of prisms", any, unions},
    Relation{"deformed", "a mesh bent into its place is the mesh made there", has<Mesh>, deformed},
    Relation{"rounded", "balls about the points of two shapes take their radii off the distance", has_rounding,
             rounded},
};

}  // namespace

std::span<const Relation> relations() { return table; }

Answers answer(const PosedPair& p) { return answer(make_shape(p.a), p.a.pose, make_shape(p.b), p.b.pose, p.margin); }

std::string check(const Relation& relation, const PosedPair& pair) {
  const Shape a = make_shape(pair.a), b = make_shape(pair.b);
  const Answers answers = answer(a, pair.a.pose, b, pair.b.pose, pair.margin);
  Random random(pair.seed);
  return relation.check({pair, a, b, answers, unit_of(pair)}, random);
}

}  // namespace tandem::relations
