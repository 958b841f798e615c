#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "mesh_contacts.h"
#include "mesh_inside.h"
#include "mesh_model.h"
#include "mesh_pair.h"
#include "mesh_traversal.h"
#include "mesh_walk.h"
#include "predicates.h"
#include "solvers.h"

namespace tandem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Collects the pairs of triangles that meet, exactly, or only whether there is one.
class MeetingPairs final : public PairVisitor {
 public:
  MeetingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test,
               std::vector<std::array<std::uint32_t, 2>>* pairs)
      : a_(a), b_(b), test_(test), pairs_(pairs) {
    traverse(a, b, test, pairs == nullptr, *this);
  }

  bool any() const { return any_; }

  bool visit(std::uint32_t i, std::uint32_t j) override {
    if (j != last_) {
      last_ = j;
      q_ = b_.corners(j);
      for (std::size_t k = 0; k < 3; ++k) q_in_a_[k] = test_.in_a(q_[k]);
    }
    if (!test_(a_.corners(i), q_, q_in_a_)) return false;
    any_ = true;
    if (pairs_) pairs_->push_back({i, j});
    return pairs_ == nullptr;
  }

 private:
  const MeshModel& a_;
  const MeshModel& b_;
  TriangleTest& test_;
  std::vector<std::array<std::uint32_t, 2>>* pairs_;
  std::uint32_t last_ = no_index;
  Corners q_, q_in_a_;
  bool any_ = false;
};

std::vector<std::array<std::uint32_t, 2>> meeting_pairs(const MeshModel& a, const MeshModel& b, TriangleTest& test) {
  std::vector<std::array<std::uint32_t, 2>> pairs;
  MeetingPairs(a, b, test, &pairs);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

bool part_inside(const MeshModel& outer, const MeshModel& inner, const Mat3& map, const Vec3& shift) {
  return outer.solid && std::any_of(inner.parts.begin(), inner.parts.end(),
                                    [&](std::uint32_t v) { return is_inside(outer, map * inner.vertices[v] + shift); });
}

// For two whose surfaces do not meet: is a part of one inside the other?
bool contained(const MeshModel& a, const MeshModel& b, const TriangleTest& test) {
  if (part_inside(a, b, test.map(), test.shift())) return true;
  const Mat3 inverse = test.map().inverse();
  return part_inside(b, a, inverse, -inverse * test.shift());
}

bool meshes_collide(const Posed& a, const Posed& b) {
  const MeshModel &ma = a.shape.mesh(), &mb = b.shape.mesh();
  TriangleTest test(a.pose, b.pose, reach(mb));
  return MeetingPairs(ma, mb, test, nullptr).any() || contained(ma, mb, test);
}

struct Nearest {
  double distance = infinity;
  Vec3 on_a = Vec3::Zero(), on_b = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // where the solver knows it
  void take(double d, const Vec3& p, const Vec3& q) {
    if (d < distance) distance = d, on_a = p, on_b = q;
  }
};

void segments_nearest(const Vec3& p, const Vec3& d, const Vec3& q, const Vec3& e, Nearest& best) {
  // Ericson, Real-Time Collision Detection, 5.1.9.
  const Vec3 r = p - q;
  const double dd = d.squaredNorm(), ee = e.squaredNorm(), f = e.dot(r), c = d.dot(r), b = d.dot(e);
  const double det = dd * ee - b * b;
  double s = det > 0 ? std::clamp((b * f - c * ee) / det, 0.0, 1.0) : 0.0;
  double t = ee > 0 ? (b * s + f) / ee : 0.0;
  if (!(t >= 0 && t <= 1)) {
    t = std::clamp(t, 0.0, 1.0);
    s = dd > 0 ? std::clamp((b * t - c) / dd, 0.0, 1.0) : 0.0;
  } else if (ee == 0) {
    s = dd > 0 ? std::clamp(-c / dd, 0.0, 1.0) : 0.0;
  }
  const Vec3 x = p + s * d, y = q + t * e;
  best.take((x - y).norm(), x, y);
}

// The foot of v on the plane of t, where it lies inside t. Edges are the segments' business.
void vertex_nearest(const Vec3& v, const Corners& t, bool v_of_a, Nearest& best) {
  const Vec3 u = t[1] - t[0], w = t[2] - t[0], n = u.cross(w), r = v - t[0];
  const double nn = n.squaredNorm();
  if (!(nn > 0)) return;
  const double s = r.cross(w).dot(n) / nn, k = u.cross(r).dot(n) / nn;
  if (!(s >= 0 && k >= 0 && s + k <= 1)) return;
  const Vec3 foot = t[0] + s * u + k * w;
  v_of_a ? best.take((v - foot).norm(), v, foot) : best.take((v - foot).norm(), foot, v);
}

void triangles_nearest(const Corners& p, const Corners& q, Nearest& best) {
  for (std::size_t i = 0; i < 3; ++i) {
    vertex_nearest(p[i], q, true, best);
    vertex_nearest(q[i], p, false, best);
    for (std::size_t j = 0; j < 3; ++j)
      segments_nearest(p[i], p[(i + 1) % 3] - p[i], q[j], q[(j + 1) % 3] - q[j], best);
  }
}

// Of surfaces that do not meet, by branch and bound; relative to A's translation, in world axes.
Nearest meshes_nearest(const Posed& a, const Posed& b) {
  const MeshModel &ma = a.shape.mesh(), &mb = b.shape.mesh();
  const Mat3 &ra = a.pose.rotation, &rb = b.pose.rotation;
  const Vec3 between = b.pose.translation - a.pose.translation;
  const Mat3 map = ra.transpose() * rb, spread = map.cwiseAbs();
  const Vec3 shift = ra.transpose() * between;
  // Rotations are orthonormal to 1e-6 only: boxes may be that much nearer than they look.
  const double slack = 1e-5 * (reach(ma) + reach(mb));
  const auto bound = [&](std::uint32_t x, std::uint32_t y) {
    const BoxOf p(ma, x), q(mb, y);
    const Vec3 gap = ((map * q.mid + shift - p.mid).cwiseAbs() - p.half - spread * q.half).cwiseMax(0);
    return std::max(0.0, gap.norm() - slack);
  };
  Nearest best;
  std::priority_queue<Item> queue;
  queue.push({bound(whole, whole), whole, whole});
  while (!queue.empty() && queue.top().bound < best.distance) {
    const Item top = queue.top();
    queue.pop();
    const auto push = [&](std::uint32_t x, std::uint32_t y) {
      if (const double d = bound(x, y); d < best.distance) queue.push({d, x, y});
    };
    const bool leaf_a = is_leaf(ma, top.a), leaf_b = is_leaf(mb, top.b);
    if (leaf_a && leaf_b) {
      each_triangle(ma, top.a, [&](std::uint32_t i) {
        each_triangle(mb, top.b, [&](std::uint32_t j) {
          Corners p = ma.corners(i), q = mb.corners(j);
          for (std::size_t k = 0; k < 3; ++k) p[k] = ra * p[k], q[k] = rb * q[k] + between;
          triangles_nearest(p, q, best);
        });
      });
    } else if (leaf_b || (!leaf_a && BoxOf(ma, top.a).half.norm() >= BoxOf(mb, top.b).half.norm())) {
      each_child(ma, top.a, [&](std::uint32_t x) { push(x, top.b); });
    } else {
      each_child(mb, top.b, [&](std::uint32_t y) { push(top.a, y); });
    }
  }
  return best;
}

Depth deepest_pair(const Posed& a, const Posed& b, std::span<const std::array<std::uint32_t, 2>> pairs,
                   const NarrowPhaseOptions& options) {
  Depth deepest;
  deepest.certain = -1;
  for (const auto& [i, j] : pairs) {
    const Corners p = a.shape.mesh().corners(i), q = b.shape.mesh().corners(j);
    const PairAnswer r =
        solve_convex(view_triangle(p), a.pose, view_triangle(q), b.pose, Request::distance, options, nullptr);
    if (-r.signed_distance > deepest.certain && r.normal.norm() > 0.5)
      deepest = {-r.signed_distance, r.normal, (r.point_a + r.point_b) / 2};
  }
  deepest.certain = std::max(0.0, deepest.certain);
  return deepest;
}

}  // namespace

PairAnswer solve_meshes(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts) {
  PairAnswer answer;
  if (request == Request::collide) {
    answer.collide = meshes_collide(a, b);
    return answer;
  }
  const MeshModel &ma = a.shape.mesh(), &mb = b.shape.mesh();
  TriangleTest test(a.pose, b.pose, reach(mb));
  const auto pairs = meeting_pairs(ma, mb, test);
  const bool inside = pairs.empty() && contained(ma, mb, test);
  if (request == Request::contacts) {
    if (pairs.empty() && !inside) return answer;
    const std::size_t first = contacts->size();
    for (Contact c : patch_contacts(ma, mb, test, pairs)) {
      c.point = a.pose * c.point;
      c.normal = (a.pose.rotation * c.normal).normalized();
      contacts->push_back(c);
    }
    answer = from_deepest(*contacts, first);
    answer.collide = true;
    return answer;
  }
  Depth depth;
  if (pairs.empty()) {
    const Nearest near = meshes_nearest(a, b);
    const Vec3 between = near.on_b - near.on_a;
    if (!inside) {
      answer.signed_distance = near.distance;
      answer.point_a = near.on_a + a.pose.translation;
      answer.point_b = near.on_b + a.pose.translation;
      answer.normal = near.distance > 0 ? between.normalized() : Vec3::UnitZ();
      return answer;
    }
    depth = {near.distance, near.distance > 0 ? Vec3(-between.normalized()) : Vec3::UnitZ(),
             near.on_a + between / 2 + a.pose.translation};
    // B inside A leaves A through the nearest wall; A inside B the other way round.
    if (part_inside(ma, mb, test.map(), test.shift())) depth.normal = -depth.normal;
  } else {
    depth = deepest_pair(a, b, pairs, for_triangles(options));
  }
  return with_depth(a, b, depth, ma.solid || mb.solid, [&](const Vec3& move) {
    return meshes_collide(a, {b.shape, Pose{b.pose.rotation, b.pose.translation + move}});
  });
}

std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b) {
  const Posed first{a, pose_a}, second{b, pose_b};
  const bool in_order = goes_first(first, second);
  const Posed &p = in_order ? first : second, &q = in_order ? second : first;
  TriangleTest test(p.pose, q.pose, reach(q.shape.mesh()));
  auto pairs = meeting_pairs(p.shape.mesh(), q.shape.mesh(), test);
  if (!in_order) {
    for (auto& pair : pairs) std::swap(pair[0], pair[1]);
    std::sort(pairs.begin(), pairs.end());
  }
  return pairs;
}

}  // namespace tandem
