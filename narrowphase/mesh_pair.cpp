#include "mesh_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "hull.h"
#include "mesh_contacts.h"
#include "mesh_inside.h"
#include "mesh_model.h"
#include "mesh_traversal.h"
#include "predicates.h"
#include "solvers.h"

namespace tandem {
namespace {

using Corners = std::array<Vec3, 3>;
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Posed {
  const Shape& shape;
  const Pose& pose;
};

bool has_triangles(const Shape& s) { return s.kind() == ShapeKind::mesh || s.kind() == ShapeKind::triangle; }

// Fixed roles for the two, whichever way round they came: the same pair is then solved with the same rounding.
bool goes_first(const Posed& a, const Posed& b) {
  const MeshModel &ma = a.shape.mesh(), &mb = b.shape.mesh();
  if (ma.unit != mb.unit) return ma.unit > mb.unit;
  if (ma.triangles.size() != mb.triangles.size()) return ma.triangles.size() > mb.triangles.size();
  const auto before = [](const auto& x, const auto& y) {
    return std::lexicographical_compare(x.data(), x.data() + x.size(), y.data(), y.data() + y.size());
  };
  const Pose &pa = a.pose, &pb = b.pose;
  if (pa.translation != pb.translation) return before(pa.translation, pb.translation);
  if (pa.rotation != pb.rotation) return before(pa.rotation, pb.rotation);
  return !std::lexicographical_compare(mb.vertices.begin(), mb.vertices.end(), ma.vertices.begin(), ma.vertices.end(),
                                       before);
}

double reach(const MeshModel& mesh) { return (mesh.centre.cwiseAbs() + mesh.half).maxCoeff(); }

// Calls visit(i, j) for the pairs of triangles that meet, exactly, until it returns true.
template <class Visit>
void each_meeting_pair(const MeshModel& a, const MeshModel& b, const TriangleTest& test, Visit&& visit) {
  std::uint32_t last = no_index;
  Corners q, q_in_a;
  MeshTraversal(a, b, test)([&](std::uint32_t i, std::uint32_t j) {
    if (j != last) {
      last = j;
      q = b.corners(j);
      for (std::size_t k = 0; k < 3; ++k) q_in_a[k] = test.in_a(q[k]);
    }
    return test(a.corners(i), q, q_in_a) && visit(i, j);
  });
}

std::vector<std::array<std::uint32_t, 2>> meeting_pairs(const MeshModel& a, const MeshModel& b,
                                                        const TriangleTest& test) {
  std::vector<std::array<std::uint32_t, 2>> pairs;
  each_meeting_pair(a, b, test, [&](std::uint32_t i, std::uint32_t j) {
    pairs.push_back({i, j});
    return false;
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// ---- What any pair with a mesh needs ----

// Largest d . x over the posed shape.
double support(const Posed& s, const Vec3& d) {
  if (has_triangles(s.shape)) {
    const MeshModel& mesh = s.shape.mesh();
    const Vec3 local = s.pose.rotation.transpose() * d;
    double most = -infinity;
    for (const std::uint32_t v : mesh.extreme) most = std::max(most, local.dot(mesh.vertices[v]));
    return most + d.dot(s.pose.translation);
  }
  Mat3 turn;  // d becomes the x axis
  const Vec3 u = d.unitOrthogonal();
  turn << d.transpose(), u.transpose(), d.cross(u).transpose();
  return s.shape.bounds({turn * s.pose.rotation, turn * s.pose.translation}).hi.x();
}

struct Depth {
  double certain = 0;  // no shorter translation separates
  Vec3 normal = Vec3::UnitZ();
  Vec3 point = Vec3::Zero();
};

// Completes the answer for an overlap of which a lower bound is known: if moving B by it along the normal separates the
// two, it is the depth; else the bound above comes from bisection along the same direction.
template <class Collide>
PairAnswer with_depth(const Posed& a, const Posed& b, const Depth& d, bool solid, Collide&& collide_moved) {
  PairAnswer answer;
  answer.collide = true;
  answer.normal = d.normal;
  const double size = a.shape.size() + b.shape.size();
  double certain = d.certain, separates = certain + 1e-12 * size;
  if (collide_moved(Vec3(d.normal * separates))) {
    const Vec3 t = b.pose.translation - a.pose.translation;
    const Pose at_a{a.pose.rotation, Vec3::Zero()}, at_b{b.pose.rotation, t};
    separates = support({a.shape, at_a}, d.normal) + support({b.shape, at_b}, -d.normal);
    separates = std::max(separates, certain) + 1e-12 * size;
    double blocked = certain;
    for (int i = 0; i < 16; ++i) {
      const double middle = (blocked + separates) / 2;
      (collide_moved(Vec3(d.normal * middle)) ? blocked : separates) = middle;
    }
    answer.status = Status::inexact;
    answer.error_bound = separates - certain;
    if (solid) certain = separates;
  }
  answer.signed_distance = -certain;
  answer.point_a = d.point + d.normal * (certain / 2);
  answer.point_b = d.point - d.normal * (certain / 2);
  return answer;
}

PairAnswer from_deepest(const std::vector<Contact>& contacts, std::size_t first) {
  PairAnswer answer;
  const Contact* deepest = nullptr;
  for (std::size_t i = first; i < contacts.size(); ++i)
    if (!deepest || contacts[i].depth > deepest->depth) deepest = &contacts[i];
  if (!deepest) return answer;
  answer.collide = deepest->depth >= 0;
  answer.signed_distance = -deepest->depth;
  answer.normal = deepest->normal;
  answer.point_a = deepest->point + deepest->normal * (deepest->depth / 2);
  answer.point_b = deepest->point - deepest->normal * (deepest->depth / 2);
  return answer;
}

NarrowPhaseOptions for_triangles(const NarrowPhaseOptions& options) {
  NarrowPhaseOptions o = options;
  o.solver.clear();  // the name was that of a solver for meshes
  return o;
}

// ---- Mesh against mesh ----

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
  const TriangleTest test(a.pose, b.pose, reach(mb));
  bool hit = false;
  each_meeting_pair(ma, mb, test, [&](std::uint32_t, std::uint32_t) { return hit = true; });
  return hit || contained(ma, mb, test);
}

// Children of a node of a hierarchy as boxes in doubles, in the mesh's frame.
struct Item {
  double bound;
  std::uint32_t a, b;  // node << 3 | lane, or 4 for the root
  bool operator<(const Item& o) const { return bound != o.bound ? bound > o.bound : a != o.a ? a > o.a : b > o.b; }
};

constexpr std::uint32_t whole = 4;  // lane of the root

struct BoxOf {
  Vec3 mid, half;
  BoxOf(const MeshModel& mesh, std::uint32_t ref) : mid(mesh.centre), half(mesh.half) {
    if ((ref & 7) == whole) return;
    const MeshNode& n = mesh.nodes[ref >> 3];
    for (int k = 0; k < 3; ++k) {
      mid[k] = mesh.centre[k] + mesh.unit * static_cast<double>(n.mid[k][ref & 7]);
      half[k] = mesh.unit * static_cast<double>(n.half[k][ref & 7]);
    }
  }
};

bool is_leaf(const MeshModel& mesh, std::uint32_t ref) {
  return (ref & 7) != whole && mesh.nodes[ref >> 3].count[ref & 7] > 0;
}

template <class Visit>
void each_child(const MeshModel& mesh, std::uint32_t ref, Visit&& visit) {
  const std::uint32_t node = (ref & 7) == whole ? 0 : mesh.nodes[ref >> 3].child[ref & 7];
  for (std::uint32_t k = 0; k < mesh.nodes[node].lanes; ++k) visit(node << 3 | k);
}

template <class Visit>
void each_triangle(const MeshModel& mesh, std::uint32_t leaf, Visit&& visit) {
  const MeshNode& n = mesh.nodes[leaf >> 3];
  for (std::uint32_t k = 0; k < n.count[leaf & 7]; ++k) visit(mesh.order[n.child[leaf & 7] + k]);
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

PairAnswer solve_meshes(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts) {
  PairAnswer answer;
  if (request == Request::collide) {
    answer.collide = meshes_collide(a, b);
    return answer;
  }
  const MeshModel &ma = a.shape.mesh(), &mb = b.shape.mesh();
  const TriangleTest test(a.pose, b.pose, reach(mb));
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

// ---- Mesh against half-space ----

PairAnswer solve_halfspace(const Posed& mesh, const Posed& half, Request request, const NarrowPhaseOptions& options,
                           std::vector<Contact>* contacts) {
  const MeshModel& m = mesh.shape.mesh();
  const Vec3 up = (half.pose.rotation * half.shape.normal()).normalized();
  const Vec3 between = mesh.pose.translation - half.pose.translation;
  const Vec3 local = mesh.pose.rotation.transpose() * up;
  const double level = half.shape.offset() - up.dot(between);
  PairAnswer answer;
  double lowest = infinity;
  std::uint32_t at = 0;
  const std::size_t first = contacts ? contacts->size() : 0;
  const auto world = [&](std::uint32_t v) { return mesh.pose * m.vertices[v]; };
  // The vertices that span the part below the plane are vertices of the hull.
  for (const std::uint32_t v : m.extreme) {
    const double height = local.dot(m.vertices[v]) - level;
    if (height < lowest) lowest = height, at = v;
    if (request == Request::contacts && height <= options.margin)
      contacts->push_back({world(v) - up * (height / 2), -up, -height, v});
  }
  if (request == Request::contacts) keep_four(*contacts, first);
  answer.collide = lowest <= 0;
  if (request == Request::collide || (request == Request::contacts && contacts->size() == first)) return answer;
  answer.signed_distance = lowest;
  answer.point_a = world(at);
  answer.point_b = answer.point_a - up * lowest;
  answer.normal = -up;
  return answer;
}

// ---- Mesh against a bounded convex ----

class MeshConvex {
 public:
  MeshConvex(const Posed& mesh, const Posed& convex, const NarrowPhaseOptions& options)
      : mesh_(mesh),
        convex_(convex),
        model_(mesh.shape.mesh()),
        view_(view(convex.shape)),
        options_(for_triangles(options)) {
    const Mat3 inverse = mesh.pose.rotation.inverse();
    box_ = convex.shape.bounds(
        {inverse * convex.pose.rotation, inverse * (convex.pose.translation - mesh.pose.translation)});
    const double slack = 1e-5 * (convex.shape.size() + 1e-6 * reach(model_));
    box_.lo -= Vec3::Constant(slack);
    box_.hi += Vec3::Constant(slack);
  }

  bool collide() const {
    bool hit = false;
    each_near(0, [&](std::uint32_t t) { return hit = solve(t, Request::collide, nullptr).collide; });
    return hit || inside();
  }

  PairAnswer distance() const {
    Depth deepest;
    deepest.certain = -1;
    each_near(0, [&](std::uint32_t t) {
      const PairAnswer r = solve(t, Request::distance, nullptr);
      if (r.collide && -r.signed_distance > deepest.certain)
        deepest = {-r.signed_distance, r.normal, (r.point_a + r.point_b) / 2};
      return false;
    });
    if (deepest.certain < 0) {
      const PairAnswer r = nearest();
      if (!inside()) return r;
      // The convex leaves through the nearest wall; the normal points from there to its inside.
      deepest = {r.signed_distance, -r.normal, (r.point_a + r.point_b) / 2};
    }
    return with_depth(mesh_, convex_, deepest, model_.solid, [&](const Vec3& move) {
      const Pose moved{convex_.pose.rotation, convex_.pose.translation + move};
      return MeshConvex(mesh_, {convex_.shape, moved}, options_).collide();
    });
  }

  PairAnswer contacts(std::vector<Contact>& out) const {
    std::vector<Contact> all, good;
    std::vector<Contact> one;
    each_near(options_.margin, [&](std::uint32_t t) {
      one.clear();
      solve(t, Request::contacts, &one);
      const Corners p = model_.corners(t);
      const Vec3 face = (mesh_.pose.rotation * (p[1] - p[0]).cross(p[2] - p[0])).stableNormalized();
      for (std::uint32_t k = 0; k < one.size(); ++k) {
        Contact c = one[k];
        c.feature = t * 4 + std::min(k, 3u);
        all.push_back(c);
        // From inside a solid only its outer side pushes; a triangle's border that the solid goes on beyond does not.
        if (!model_.solid || c.normal.dot(face) > 0.5) good.push_back(c);
      }
      return false;
    });
    if (good.empty()) good = all;
    const std::size_t first = out.size();
    merge(good, out);
    PairAnswer answer;
    if (out.size() == first) {
      if (!inside()) return answer;
      answer = distance();
      out.push_back({(answer.point_a + answer.point_b) / 2, answer.normal, -answer.signed_distance, 0});
      return answer;
    }
    return from_deepest(out, first);
  }

 private:
  PairAnswer solve(std::uint32_t t, Request request, std::vector<Contact>* contacts) const {
    const Corners p = model_.corners(t);
    return solve_convex(view_triangle(p), mesh_.pose, view_, convex_.pose, request, options_, contacts);
  }

  double gap(const BoxOf& b) const {
    const Vec3 lo = b.mid - b.half, hi = b.mid + b.half;
    return (box_.lo - hi).cwiseMax(lo - box_.hi).cwiseMax(0).norm();
  }

  // Triangles whose boxes come within `margin` of the convex's, until visit returns true.
  template <class Visit>
  void each_near(double margin, Visit&& visit) const {
    const double reach = margin * (1 + 1e-5);
    if (gap(BoxOf(model_, whole)) > reach) return;
    std::vector<std::uint32_t> stack{whole};
    bool done = false;
    while (!stack.empty() && !done) {
      const std::uint32_t ref = stack.back();
      stack.pop_back();
      if (is_leaf(model_, ref))
        each_triangle(model_, ref, [&](std::uint32_t t) { done = done || visit(t); });
      else
        each_child(model_, ref, [&](std::uint32_t c) {
          if (gap(BoxOf(model_, c)) <= reach) stack.push_back(c);
        });
    }
  }

  PairAnswer nearest() const {
    PairAnswer best;
    best.signed_distance = infinity;
    std::priority_queue<Item> queue;
    queue.push({0, whole, 0});
    while (!queue.empty() && queue.top().bound * (1 - 1e-5) < best.signed_distance) {
      const std::uint32_t ref = queue.top().a;
      queue.pop();
      if (is_leaf(model_, ref))
        each_triangle(model_, ref, [&](std::uint32_t t) {
          if (const PairAnswer r = solve(t, Request::distance, nullptr); r.signed_distance < best.signed_distance)
            best = r;
        });
      else
        each_child(model_, ref, [&](std::uint32_t c) { queue.push({gap(BoxOf(model_, c)), c, 0}); });
    }
    return best;
  }

  // For a convex that no triangle meets: inside the solid as a whole?
  bool inside() const {
    if (!model_.solid) return false;
    const Vec3 local = convex_.shape.kind() == ShapeKind::convex ? convex_.shape.hull().inside : Vec3(0, 0, 0);
    const Vec3 world = convex_.pose.rotation * local + (convex_.pose.translation - mesh_.pose.translation);
    return is_inside(model_, mesh_.pose.rotation.inverse() * world);
  }

  // Contacts of one direction are one patch: at most four of them, the deepest first choice.
  static void merge(const std::vector<Contact>& all, std::vector<Contact>& out) {
    std::vector<std::size_t> order(all.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
      return all[i].depth != all[j].depth ? all[i].depth > all[j].depth : all[i].feature < all[j].feature;
    });
    std::vector<std::vector<Contact>> patches;
    for (const std::size_t i : order) {
      const auto same = std::find_if(patches.begin(), patches.end(), [&](const std::vector<Contact>& p) {
        return p.front().normal.dot(all[i].normal) > 0.9;
      });
      if (same == patches.end())
        patches.push_back({all[i]});
      else
        same->push_back(all[i]);
    }
    const std::size_t first = out.size();
    for (auto& patch : patches) {
      keep_four(patch, 0);
      out.insert(out.end(), patch.begin(), patch.end());
    }
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
              [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
  }

  const Posed mesh_, convex_;
  const MeshModel& model_;
  const ConvexView view_;
  const NarrowPhaseOptions options_;
  Bounds box_;  // of the convex, in the mesh's frame
};

// A has triangles.
PairAnswer solve_with_mesh_first(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                                 std::vector<Contact>* contacts) {
  if (has_triangles(b.shape)) return solve_meshes(a, b, request, options, contacts);
  if (b.shape.kind() == ShapeKind::halfspace) return solve_halfspace(a, b, request, options, contacts);
  const MeshConvex pair(a, b, options);
  if (request == Request::contacts) return pair.contacts(*contacts);
  if (request == Request::distance) return pair.distance();
  PairAnswer answer;
  answer.collide = pair.collide();
  return answer;
}

}  // namespace

PairAnswer solve_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts) {
  const Posed first{a, pose_a}, second{b, pose_b};
  const bool in_order = has_triangles(a) && (!has_triangles(b) || goes_first(first, second));
  if (in_order) return solve_with_mesh_first(first, second, request, options, contacts);
  const std::size_t begin = contacts ? contacts->size() : 0;
  PairAnswer answer = solve_with_mesh_first(second, first, request, options, contacts);
  swap_answer(answer, contacts, begin);
  return answer;
}

std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b) {
  const Posed first{a, pose_a}, second{b, pose_b};
  const bool in_order = goes_first(first, second);
  const Posed &p = in_order ? first : second, &q = in_order ? second : first;
  auto pairs = meeting_pairs(p.shape.mesh(), q.shape.mesh(), TriangleTest(p.pose, q.pose, reach(q.shape.mesh())));
  if (!in_order) {
    for (auto& pair : pairs) std::swap(pair[0], pair[1]);
    std::sort(pairs.begin(), pairs.end());
  }
  return pairs;
}

}  // namespace tandem
