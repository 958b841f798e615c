#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory_resource>
#include <span>

#include "manifold/manifold.h"
#include "meshes/contacts/mesh_contacts.h"
#include "meshes/depth/mesh_inside.h"
#include "meshes/depth/mesh_ways.h"
#include "meshes/mesh_pair.h"
#include "meshes/traversal/mesh_nearest.h"
#include "meshes/traversal/mesh_traversal.h"
#include "pairs/centre_test.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"
#include "triangles/predicates.h"
#include "triangles/triangle_rows.h"

namespace tandem {
namespace {

using TrianglePairs = std::pmr::vector<std::array<std::uint32_t, 2>>;

// What a query usually needs for them lies on the stack.
struct PairMemory {
  alignas(std::max_align_t) std::array<std::byte, std::size_t{16} << 10> usual;
  std::pmr::monotonic_buffer_resource resource{usual.data(), usual.size()};
};

// What is known of how far apart two meshes are that do not meet.
struct Apart {
  static constexpr std::size_t most = 32;
  double of_others = infinity;  // any two triangles but these, in A's frame
  std::array<std::array<std::uint32_t, 2>, most> close{};
  std::size_t count = 0;  // of `close`; beyond `most` nothing is known

  void add(const std::array<std::uint32_t, 2>& pair) {
    if (count < most) close[count] = pair;
    ++count;
  }
  void join(const Apart& other) {
    of_others = std::min(of_others, other.of_others);
    for (std::size_t i = 0; i < std::min(other.count, most); ++i) add(other.close[i]);
    if (other.count > most) count = most + 1;
  }
};

// Collects the pairs of triangles that meet, exactly, or only whether there is one; and what is known if there is none.
class MeetingPairs final : public PairVisitor {
 public:
  MeetingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test, TrianglePairs* pairs, Apart* apart)
      : a_(a), b_(b), test_(test), pairs_(pairs), apart_(apart) {
    traverse(a, b, test, pairs == nullptr, *this, apart == nullptr ? nullptr : &apart->of_others);
    decide_waiting();
  }
  MeetingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test, NodePair part, TrianglePairs& pairs,
               Apart* apart)
      : a_(a), b_(b), test_(test), pairs_(&pairs), apart_(apart) {
    traverse(a, b, test, part, *this, apart == nullptr ? nullptr : &apart->of_others);
    decide_waiting();
  }

  bool any() const { return any_; }

  bool visit(std::uint32_t i, std::uint32_t j) override {
    waiting_[count_] = {i, j};
    rows_.set(count_++, a_.corners(i), b_.corners(j));
    if (count_ == TriangleRows::most || pairs_ == nullptr) decide_waiting();
    return pairs_ == nullptr && any_;
  }

 private:
  void decide_waiting() {
    if (count_ == 0) return;
    const TriangleVerdicts verdicts = compare_triangles(rows_, count_, test_);
    for (std::size_t k = 0; k < count_; ++k) {
      const auto [i, j] = waiting_[k];
      if ((verdicts.meet >> k & 1u) != 0 || ((verdicts.unknown >> k & 1u) != 0 && meet(i, j))) {
        any_ = true;
        if (pairs_ != nullptr) pairs_->push_back({i, j});
      } else if (apart_ != nullptr) {
        apart_->add({i, j});
      }
    }
    count_ = 0;
  }

  bool meet(std::uint32_t i, std::uint32_t j) {
    const Corners q = b_.corners(j);
    return test_(a_.corners(i), q, {test_.in_a(q[0]), test_.in_a(q[1]), test_.in_a(q[2])});
  }

  const MeshModel& a_;
  const MeshModel& b_;
  TriangleTest& test_;
  TrianglePairs* pairs_;
  Apart* apart_;
  TriangleRows rows_{};  // columns that are not set are computed with the others: what is in them must be numbers
  std::array<std::array<std::uint32_t, 2>, TriangleRows::most> waiting_;
  std::size_t count_ = 0;
  bool any_ = false;
};

// Sorted: who found them and when leaves no trace.
TrianglePairs meeting_pairs(const Posed& a, const Posed& b, TriangleTest& test, const PartRunner& runner,
                            PairMemory& memory, Apart* apart) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  constexpr std::size_t large = 16384, wanted = 64;  // triangles of both; parts
  std::vector<NodePair> parts;
  if (runner && ma.triangles.size() + mb.triangles.size() >= large)
    parts = traversal_parts(ma, mb, test, wanted, apart == nullptr ? nullptr : &apart->of_others);
  TrianglePairs pairs(&memory.resource);
  if (parts.size() < wanted) {
    MeetingPairs(ma, mb, test, &pairs, apart);
  } else {
    std::vector<TrianglePairs> found(parts.size());
    std::vector<Apart> apart_there(apart == nullptr ? 0 : parts.size());
    runner(parts.size(), [&](std::size_t part) {
      TriangleTest own(a.pose, b.pose, reach(mb));
      MeetingPairs(ma, mb, own, parts[part], found[part], apart == nullptr ? nullptr : &apart_there[part]);
    });
    for (const Apart& there : apart_there) apart->join(there);
    for (const TrianglePairs& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  }
  std::sort(pairs.begin(), pairs.end(), [](const auto& x, const auto& y) {
    return (std::uint64_t{x[0]} << 32 | x[1]) < (std::uint64_t{y[0]} << 32 | y[1]);
  });
  return pairs;
}

bool part_inside(const Posed& outer, const Posed& inner) {
  const MeshModel &o = mesh_of(outer.shape), &i = mesh_of(inner.shape);
  return o.solid && std::any_of(i.parts.begin(), i.parts.end(), [&](const MeshModel::Part& part) {
           return is_inside(o, outer.pose, i.vertices[part[0]], inner.pose);
         });
}

// For two whose surfaces do not meet: is a part of one inside the other?
bool contained(const Posed& a, const Posed& b) { return part_inside(a, b) || part_inside(b, a); }

bool meshes_collide(const Posed& a, const Posed& b) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  TriangleTest test(a.pose, b.pose, reach(mb));
  return MeetingPairs(ma, mb, test, nullptr, nullptr).any() || contained(a, b);
}

// How far apart two triangles that do not meet are, or a little less.
double gap_between(const Corners& p, const Corners& q) {
  Nearest nearest;
  triangles_nearest(p, q, nearest);
  if (!(nearest.distance > 0)) return 0;
  // Points found may be a little farther from each other than the nearest: what counts is what lies between two planes.
  const Vec3 normal = (nearest.on_b - nearest.on_a) / nearest.distance;
  double far_p = 0, near_q = infinity, span = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    far_p = std::max(far_p, normal.dot(p[k] - p[0]));
    near_q = std::min(near_q, normal.dot(q[k] - p[0]));
    span = std::max({span, (p[k] - p[0]).lpNorm<1>(), (q[k] - p[0]).lpNorm<1>()});
  }
  return std::max(0.0, (1 - tolerance::askew_with_room) * (near_q - far_p) - tolerance::place_rounding_of_nearest * span);
}

// A lower bound on how far apart two meshes are that do not meet; 0 if none is known.
double gap_of(const MeshModel& a, const MeshModel& b, const TriangleTest& test, const Apart& apart) {
  if (apart.count > Apart::most) return 0;
  double gap = apart.of_others;
  for (const auto& [i, j] : std::span(apart.close).first(apart.count)) {
    Corners q = b.corners(j);
    for (Vec3& corner : q) corner = test.in_a(corner);
    gap = std::min(gap, gap_between(a.corners(i), q) - 4 * test.delta());
  }
  return std::max(0.0, gap);
}

// What is known of an overlap.
struct DepthBound {
  double certain = 0;  // no shorter translation separates
  Vec3 normal = Vec3::UnitZ();
  Vec3 point = Vec3::Zero();
};

DepthBound deepest_pair(const Posed& a, const Posed& b, std::span<const std::array<std::uint32_t, 2>> pairs,
                        const NarrowPhaseOptions& options) {
  DepthBound deepest;
  deepest.certain = -1;
  for (const auto& [i, j] : pairs) {
    const Corners p = mesh_of(a.shape).corners(i), q = mesh_of(b.shape).corners(j);
    const PairAnswer r =
        solve_convex(TriangleView(p), a.pose, TriangleView(q), b.pose, Request::distance, options, nullptr);
    if (-r.signed_distance > deepest.certain && r.normal.norm() > 0.5)
      deepest = {-r.signed_distance, r.normal, (r.point_a + r.point_b) / 2};
  }
  deepest.certain = std::max(0.0, deepest.certain);
  return deepest;
}

constexpr std::uint32_t of_no_feature = 0xffffffffu;  // of a contact that stands for the overlap as a whole

constexpr std::size_t small_meshes = std::size_t{1} << 18;  // triangles of the one times those of the other

// A triangle, or what encloses its hull.
bool bounds_convex(const Posed& s) { return s.shape.is_convex() || mesh_of(s.shape).own_hull; }

// Which of two is taken for the convex set that it bounds: a triangle before a mesh, a solid before a surface, of alike
// surfaces the second, which is no larger.
bool first_is_body(const Posed& a, const Posed& b) {
  const auto rank = [](const Posed& s) { return mesh_of(s.shape).convex ? 2 : mesh_of(s.shape).own_hull ? 1 : 0; };
  return a.shape.is_convex() || (!b.shape.is_convex() && rank(a) > rank(b));
}

// Of a mesh and one that bounds a convex set: as with that set.
PairAnswer as_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                     std::vector<Contact>* contacts) {
  const bool exchanged = first_is_body(a, b);
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  PairAnswer answer =
      solve_mesh_convex(exchanged ? b : a, exchanged ? a : b, request, for_triangles(options), contacts);
  if (exchanged) swap_answer(answer, contacts, first);
  return answer;
}

// Of two that touch.
PairAnswer with_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                       std::vector<Contact>* contacts) {
  PairAnswer answer = as_convex(a, b, request, options, contacts);
  answer.collide = true;
  answer.signed_distance = std::min(answer.signed_distance, 0.0);
  return answer;
}

PairAnswer with_hulls(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                      std::vector<Contact>* contacts) {
  PairAnswer answer =
      solve_convex(view_hull(a.shape), a.pose, view_hull(b.shape), b.pose, request, for_triangles(options), contacts);
  answer.collide = true;
  answer.signed_distance = std::min(answer.signed_distance, 0.0);
  return answer;
}

// Does a vertex of each part of the other mesh stay outside `outer`'s hull however that moves by at most `way`? No part
// can come to lie inside then.
bool stays_outside(const Posed& outer, const Posed& other, double way) {
  const MeshModel &o = mesh_of(outer.shape), &m = mesh_of(other.shape);
  const auto is_outside = [&](std::uint32_t v) {
    const Vec3 p = outer.pose.rotation.transpose() *
                   (other.pose.rotation * m.vertices[v] + (other.pose.translation - outer.pose.translation));
    return std::any_of(o.hull.faces.begin(), o.hull.faces.end(),
                       [&](const Hull::Face& f) { return f.normal.dot(p) - f.offset > way; });
  };
  if (m.parts.size() == 1) return std::any_of(m.extreme.begin(), m.extreme.end(), is_outside);
  return std::all_of(m.parts.begin(), m.parts.end(),
                     [&](const MeshModel::Part& part) { return std::any_of(part.begin(), part.end(), is_outside); });
}

// A surface has nothing inside: may the body it bounds stand for it all the same, as the other cannot slip into it on a
// way shorter than that which parts them?
bool stands_for(const Posed& s, const Posed& other, double way) {
  return s.shape.is_convex() || mesh_of(s.shape).convex || stays_outside(s, other, way);
}

// The distance of two that do not meet.
PairAnswer distance_apart(const Posed& a, const Posed& b, const NarrowPhaseOptions& options) {
  NearestSearch search(a, b);
  const Nearest near = search();
  PairAnswer answer;
  // They do not meet, exactly: however near they are, it is not 0.
  answer.signed_distance = std::max(near.distance, std::numeric_limits<double>::min());
  answer.point_a = near.on_a + a.pose.translation;
  answer.point_b = near.on_b + a.pose.translation;
  answer.normal = search.normal(for_triangles(options));
  return answer;
}

// The depth of two that collide: triangles `pairs` meet, or one is inside the other. A's translation is zero.
PairAnswer depth_answer(const Posed& a, const Posed& b, std::span<const std::array<std::uint32_t, 2>> pairs,
                        const NarrowPhaseOptions& options) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  const auto body_stands = [&](double way) {
    return first_is_body(a, b) ? stands_for(a, b, way) : stands_for(b, a, way);
  };
  PairAnswer answer;
  DepthBound depth;
  if (pairs.empty()) {
    NearestSearch search(a, b);
    const Nearest near = search();
    depth = {near.distance, -search.normal(for_triangles(options)), (near.on_a + near.on_b) / 2};
    // B inside A leaves A through the nearest wall; A inside B the other way round.
    if (part_inside(a, b)) depth.normal = -depth.normal;
  } else {
    depth = deepest_pair(a, b, pairs, for_triangles(options));
  }
  WaysOut ways(a, b, [&](const Vec3& move, std::vector<std::array<std::uint32_t, 2>>* found) {
    const Pose at{b.pose.rotation, b.pose.translation + move};
    const Posed moved{b.shape, at};
    if (found == nullptr) return meshes_collide(a, moved);
    TriangleTest there(a.pose, at, reach(mb));
    PairMemory own;
    const TrianglePairs all = meeting_pairs(a, moved, there, options.parts, own, nullptr);
    found->assign(all.begin(), all.end());
    return !found->empty() || contained(a, moved);
  });
  const double rounding = tolerance::translation_slack * (a.shape.size() + b.shape.size());
  answer.collide = true;
  if (ways.is_out(depth.normal, depth.certain + rounding)) {
    answer.signed_distance = -depth.certain;
    answer.normal = depth.normal;
    answer.point_a = depth.point + depth.normal * (depth.certain / 2);
    answer.point_b = depth.point - depth.normal * (depth.certain / 2);
    return answer;
  }
  WayOut out;
  out.certain = depth.certain;
  ways.leave_walls(pairs, out);
  out.certain = std::min(out.certain, out.length);  // which was tried: a sliver's depth may be more, for rounding
  const auto is_known = [&] { return out.length <= out.certain + rounding; };
  if (!is_known()) {
    PairAnswer body;
    body.status = Status::inexact;
    body.error_bound = infinity;
    if (bounds_convex(a) || bounds_convex(b)) {
      const PairAnswer with_body = with_convex(a, b, Request::distance, options, nullptr);
      // Of two that only touch, rounding may have set the body apart, wedged in as it may be.
      if (body_stands(-with_body.signed_distance) &&
          ways.is_out(with_body.normal, rounding - with_body.signed_distance))
        body = with_body;
      if (body.status == Status::ok) return body;
    }
    // What parts the hulls parts the meshes.
    const PairAnswer hulls = solve_convex(view_hull(a.shape), a.pose, view_hull(b.shape), b.pose, Request::distance,
                                          for_triangles(options), nullptr);
    if (const double parts = std::max(0.0, -hulls.signed_distance); parts < out.length) {
      out.length = parts;
      out.normal = hulls.normal;
      out.point = (hulls.point_a + hulls.point_b) / 2;
    }
    ways.attempt(depth.normal, out);
    // Small meshes are worth more work.
    if (ma.triangles.size() * mb.triangles.size() <= small_meshes) {
      std::vector<Contact> pushes;
      TriangleTest test(a.pose, b.pose, reach(mb));
      if (!pairs.empty()) patch_contacts(ma, mb, test, pairs, options.parts, pushes);
      for (Contact& c : pushes) c.normal = (a.pose.rotation * c.normal).normalized();
      ways.attempt(pushes, out);
      for (auto at = pushes.begin(); at != pushes.end(); ++at)
        if (std::none_of(pushes.begin(), at, [&](const Contact& o) { return o.normal.dot(at->normal) > one_patch; }))
          ways.attempt(at->normal, out);
      ways.shorten(out);
      ways.confirm(out);
      // Where they are last to part.
      const Pose at{b.pose.rotation,
                    b.pose.translation + (out.length + tolerance::least_apart * (a.shape.size() + b.shape.size())) * out.normal};
      out.point = NearestSearch(a, {b.shape, at})().on_a - out.normal * (out.length / 2);
    }
    if (body.error_bound < out.length - out.certain) return body;
  }
  if (is_known()) {
    out.length = out.certain;  // without what rounding asked for
  } else {
    answer.status = Status::inexact;
    answer.error_bound = out.length - out.certain;
  }
  answer.signed_distance = -out.length;
  answer.normal = out.normal;
  answer.point_a = out.point + out.normal * (out.length / 2);
  answer.point_b = out.point - out.normal * (out.length / 2);
  return answer;
}

// At most how far a point (in the world) lies from a mesh; < 0 inside a solid, which has a ball about it that large.
double distance_of_point(const Posed& mesh, const Vec3& point, const NarrowPhaseOptions& options) {
  const Shape ball(Sphere{0});
  const Pose at{Mat3::Identity(), point};
  const PairAnswer r = solve_mesh_convex(mesh, {ball, at}, Request::distance, options, nullptr);
  return mesh_of(mesh.shape).solid ? r.signed_distance + r.error_bound : std::max(0.0, r.signed_distance);
}

// A length that any translation has that separates two meshes that collide: that of the deepest of some triangles that
// meet, and by how much the balls about a point, in the one and in the other, reach past what it lies outside of
// either.
double certain_depth(const Posed& a, const Posed& b, std::span<const std::array<std::uint32_t, 2>> pairs,
                     std::span<const Contact> contacts, const NarrowPhaseOptions& options) {
  constexpr std::size_t most_pairs = 32;  // whose depth is looked at: each takes as long as a distance of triangles
  double certain = deepest_pair(a, b, pairs.first(std::min(pairs.size(), most_pairs)), options).certain;
  for (const Contact& c : contacts) {
    if (!(c.depth > certain)) continue;
    // On A's surface, on B's, and midway, but for contacts that were moved along a wall.
    for (const double part : {0.5, -0.5, 0.0}) {
      const Vec3 point = c.point + part * c.depth * c.normal;
      certain = std::max(certain, -distance_of_point(a, point, options) - distance_of_point(b, point, options));
    }
  }
  return certain;
}

// Does one direction push all contacts? Several, as of a floor and a wall, separate together.
bool has_one_normal(std::span<const Contact> contacts) {
  return std::all_of(contacts.begin(), contacts.end(),
                     [&](const Contact& c) { return c.normal.dot(contacts.front().normal) > one_patch; });
}

// The answer to contacts of two meshes that collide: their deepest, and how far off its depth may be. Contacts that are
// deeper than a translation that separates, or push along one direction by less than any that does, give way to the
// shortest translation that is known.
PairAnswer bounded_answer(const Posed& a, const Posed& b, std::span<const std::array<std::uint32_t, 2>> pairs,
                          const NarrowPhaseOptions& options, std::size_t first, std::vector<Contact>& contacts) {
  PairAnswer answer = from_deepest(contacts, first);
  answer.collide = true;
  if (!options.mesh_bounds) {
    answer.status = Status::unproven;
    return answer;
  }
  const double depth = -answer.signed_distance, slack = tolerance::translation_slack * (a.shape.size() + b.shape.size());
  const auto found = [&] { return std::span(contacts).subspan(first); };
  // Seen from A's translation: far out, B's would be rounded.
  const Pose at_a{a.pose.rotation, Vec3::Zero()};
  const Pose moved{b.pose.rotation, b.pose.translation - a.pose.translation + (depth + slack) * answer.normal};
  double shortest = depth, certain = 0;  // the true depth lies between
  bool separates = true;
  if (meshes_collide({a.shape, at_a}, {b.shape, moved})) {
    separates = false;
    const PairAnswer out = solve_meshes(a, b, Request::distance, options, nullptr);
    shortest = -out.signed_distance;
    certain = shortest - out.error_bound;
    if (depth > shortest + slack || (certain > depth + slack && has_one_normal(found()))) {
      const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
      contacts.erase(std::remove_if(begin, contacts.end(), [&](const Contact& c) { return c.depth >= shortest; }),
                     contacts.end());
      contacts.push_back({(out.point_a + out.point_b) / 2, out.normal, shortest, of_no_feature});
      return out;
    }
  } else {
    certain = certain_depth(a, b, pairs, found(), for_triangles(options));
  }
  const double off = std::max(depth - certain, shortest - depth);
  if (off > slack || !separates) {
    answer.status = Status::inexact;
    answer.error_bound = std::max(off, slack);
  }
  return answer;
}

}  // namespace

PairAnswer solve_meshes(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts) {
  PairAnswer answer;
  if (request == Request::collide) {
    answer.collide = meshes_collide(a, b);
    return answer;
  }
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  TriangleTest test(a.pose, b.pose, reach(mb));
  PairMemory memory;
  Apart apart;
  const bool wants_gap = request == Request::contacts && options.mesh_gaps;
  const TrianglePairs pairs = meeting_pairs(a, b, test, options.parts, memory, wants_gap ? &apart : nullptr);
  const bool inside = pairs.empty() && contained(a, b);
  const auto both_stand = [&](double way) { return stands_for(a, b, way) && stands_for(b, a, way); };
  const auto body_stands = [&](double way) {
    return first_is_body(a, b) ? stands_for(a, b, way) : stands_for(b, a, way);
  };
  if (request == Request::contacts) {
    const std::size_t first = contacts->size();
    if (pairs.empty() && !inside) {
      // A triangle has a margin as all convex shapes have.
      if (options.margin > 0 && (a.shape.is_convex() || b.shape.is_convex()))
        answer = as_convex(a, b, request, options, contacts);
      // They do not meet, exactly: what rounding took for a touch is a gap.
      for (Contact& c : std::span(*contacts).subspan(first))
        c.depth = std::min(c.depth, -std::numeric_limits<double>::min());
      answer.signed_distance = std::max(answer.signed_distance, std::numeric_limits<double>::min());
      answer.collide = false;
      if (contacts->size() == first) answer.signed_distance = wants_gap ? gap_of(ma, mb, test, apart) : 0;
      return answer;
    }
    if (ma.own_hull && mb.own_hull) {
      // Of their hulls, unless these hardly touch and miss each other by rounding.
      answer = with_hulls(a, b, request, options, contacts);
      if (contacts->size() > first && both_stand(-answer.signed_distance)) return answer;
      contacts->resize(first);
    }
    // Which way a triangle's corners go round, or those of a surface with a border, says nothing: it has no inside.
    const bool has_convex = bounds_convex(a) || bounds_convex(b);
    const bool inside_known = ma.closed && mb.closed;
    const auto add_patches = [&] { return patch_contacts(ma, mb, test, pairs, options.parts, *contacts); };
    PatchSides sides;
    if (!has_convex || inside_known) sides = add_patches();
    if (has_convex && (!sides.sure || sides.in_corner)) {
      contacts->resize(first);
      answer = with_convex(a, b, request, options, contacts);
      if (contacts->size() > first) {
        if (body_stands(-answer.signed_distance)) return answer;
        contacts->resize(first);
        sides = add_patches();
        // Through the surface into what it bounds may be the shorter way.
        const PairAnswer way = solve_meshes(a, b, Request::distance, options, nullptr);
        const double slack = tolerance::translation_slack * (a.shape.size() + b.shape.size());
        if (way.status == Status::ok && from_deepest(*contacts, first).signed_distance < way.signed_distance - slack) {
          contacts->resize(first);
          contacts->push_back({(way.point_a + way.point_b) / 2, way.normal, -way.signed_distance, 0});
          return way;
        }
      }
    }
    if (!sides.sure) touching_contacts(ma, mb, test, pairs, first, *contacts);
    for (Contact& c : std::span(*contacts).subspan(first)) {
      c.point = a.pose * c.point;
      c.normal = (a.pose.rotation * c.normal).normalized();
    }
    return bounded_answer(a, b, pairs, options, first, *contacts);
  }
  const bool touching = inside || !pairs.empty();
  if (touching && (a.shape.is_convex() || b.shape.is_convex())) return with_convex(a, b, request, options, contacts);
  if (ma.own_hull && mb.own_hull && touching) {
    const PairAnswer hulls = with_hulls(a, b, request, options, contacts);
    if (both_stand(-hulls.signed_distance)) return hulls;
  }
  if (!touching) return distance_apart(a, b, options);
  // Seen from A's translation: far out, those of moved bodies would be rounded.
  const Pose at_a{a.pose.rotation, Vec3::Zero()}, at_b{b.pose.rotation, b.pose.translation - a.pose.translation};
  answer = depth_answer({a.shape, at_a}, {b.shape, at_b}, pairs, options);
  answer.point_a += a.pose.translation;
  answer.point_b += a.pose.translation;
  return answer;
}

std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b) {
  if (test_hulls(a, pose_a, b, pose_b).at_least > 0) return {};
  const Posed first{a, pose_a}, second{b, pose_b};
  const bool in_order = goes_first(first, second);
  const Posed &p = in_order ? first : second, &q = in_order ? second : first;
  TriangleTest test(p.pose, q.pose, reach(mesh_of(q.shape)));
  PairMemory memory;
  const TrianglePairs found = meeting_pairs(p, q, test, {}, memory, nullptr);
  std::vector<std::array<std::uint32_t, 2>> pairs(found.begin(), found.end());
  if (!in_order) {
    for (auto& pair : pairs) std::swap(pair[0], pair[1]);
    std::sort(pairs.begin(), pairs.end());
  }
  return pairs;
}

}  // namespace tandem
