// Contacts of two meshes whose surfaces only touch.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "manifold/manifold.h"
#include "manifold/patch_collector.h"
#include "meshes/contacts/mesh_contacts.h"
#include "meshes/contacts/posed_meshes.h"
#include "meshes/traversal/box_descent.h"
#include "meshes/traversal/mesh_nearest.h"
#include "meshes/traversal/point_in_mesh.h"
#include "meshes/traversal/touching_faces.h"
#include "pairs/convex_pair.h"
#include "shapes/lent_memory.h"
#include "shapes/shape_insides.h"
#include "shapes/support.h"
#include "tolerances.h"

namespace tandem {
namespace {

// Contacts of surfaces that only touch, or are coplanar, and so cross along no curve, along the direction that
// separates the intersecting triangles; if there is none (or one contains the other) that of least overlap of the hulls
// is used.
class Touching {
 public:
  Touching(const PosedMeshes& m, std::span<const TrianglePair> pairs, Memory memory)
      : m_(m),
        met_(pairs),
        slack_(tolerance::in_plane * (m.a.half + m.b.half).norm()),
        meter_(m.limit),
        memory_(memory),
        faces_(m.a, m.b, 0, slack_, meter_, memory) {
    faces_.reserve(pairs.size());
    for (const TrianglePair& pair : pairs) {
      meter_.spend();
      faces_.add(pair, m.corners(true, pair[0]), m.corners(false, pair[1]));
    }
    faces_.separate(Vec3::Zero());
    n_ = faces_.direction();
    depth_ = faces_.deepest_along(n_);
  }

  /// True if there is such a direction, to rounding.
  bool separable() const { return faces_.separable(); }

  /// Adds the triangles between which rounding leaves a gap where others touch: the contacts span the whole touch.
  void add_near(const Posed& a, const Posed& b) {
    const auto meet = [&](std::uint32_t i, std::uint32_t j) {
      return std::binary_search(met_.begin(), met_.end(), TrianglePair{i, j});
    };
    const auto visit = [&](const TrianglePair& pair, const Nearest& near) {
      if (near.distance == 0) return true;
      const Corners p = m_.corners(true, pair[0]), q = m_.corners(false, pair[1]);
      if (TouchingFaces::overlap(p, q, n_) <= slack_) faces_.add(pair, p, q);
      return true;
    };
    NearestSearch(a, b, m_.limit).each_within(slack_, meet, visit, {});
  }

  void append(std::vector<Contact>& contacts) {
    if (!separable()) take_direction_of_hulls();
    const double size = (m_.a.half + m_.b.half).norm();
    const std::size_t first = contacts.size();
    if (faces_.size() == 0) contacts.push_back({place_in_both(), n_, depth_, 0});
    for (std::size_t k = 0; k < faces_.size(); ++k) {
      meter_.spend();
      const double depth = faces_.overlap(k, n_);
      if (depth < depth_ - slack_) continue;
      meter_.spend(32);
      const TriangleView p(faces_.faces(k).a), q(faces_.faces(k).b);
      const PairAnswer near = solve_convex(p, {}, q, {}, Request::distance, {}, nullptr);
      const std::size_t known = contacts.size();
      append_manifold(p, q, {Mat3::Identity(), Vec3::Zero()},
                      {.signed_distance = -depth, .point_a = near.point_a, .point_b = near.point_b, .normal = n_},
                      slack_, {}, contacts);
      std::size_t end = known;
      for (std::size_t c = known; c < contacts.size(); ++c) {
        const Contact found = contacts[c];
        const bool again = std::any_of(contacts.begin() + static_cast<std::ptrdiff_t>(first),
                                       contacts.begin() + static_cast<std::ptrdiff_t>(known),
                                       [&](const Contact& o) { return (o.point - found.point).norm() < slack_; });
        if (!again)
          contacts[end++] = {found.point, n_, std::max(0.0, found.depth),
                             feature_of(1, 8 * faces_.pair(k)[0] + found.feature % 8)};
      }
      contacts.resize(end);
      if (contacts.size() - first > most_points) keep_outer(contacts, first);
    }
    keep_widest(contacts, first, size);
  }

 private:
  static constexpr std::size_t most_points = 128;  // compared with each other
  static constexpr std::size_t at_once = 16;       // vertices between two counts of work

  // Keeps those farthest in sixteen directions along the contact's plane, the first among equals.
  void keep_outer(std::vector<Contact>& contacts, std::size_t first) const {
    constexpr int directions = 16;
    const Vec3 u = any_perpendicular(n_), v = n_.cross(u);
    const double alike_here = tolerance::alike * (m_.a.half + m_.b.half).norm();
    std::array<std::size_t, directions> outer;
    for (int d = 0; d < directions; ++d) {
      const double angle = d * (2 * std::numbers::pi / directions);
      const Vec3 direction = std::cos(angle) * u + std::sin(angle) * v;
      std::size_t best = first;
      for (std::size_t c = first + 1; c < contacts.size(); ++c)
        if (direction.dot(contacts[c].point - contacts[best].point) > alike_here) best = c;
      outer[static_cast<std::size_t>(d)] = best;
    }
    std::sort(outer.begin(), outer.end());
    const auto end = std::unique(outer.begin(), outer.end());
    std::size_t kept = first;
    for (auto at = outer.begin(); at != end; ++at) contacts[kept++] = contacts[*at];
    contacts.resize(kept);
  }

  struct Reach {
    double high, low;  // of A's hull, of B's
  };
  Reach reach_of_hulls(const Vec3& n) {
    Reach r{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    std::size_t seen = 0;
    const auto count = [&] {
      if (seen++ % at_once == 0) meter_.spend(2);
    };
    for (const std::uint32_t v : m_.a.extreme(m_.limit)) count(), r.high = std::max(r.high, n.dot(m_.vertex(true, v)));
    for (const std::uint32_t v : m_.b.extreme(m_.limit)) count(), r.low = std::min(r.low, n.dot(m_.vertex(false, v)));
    return r;
  }

  // The centre of the boxes' intersection, midway between the hulls' surfaces.
  Vec3 middle() {
    const Vec3 centre_b = m_.frame.in_a(m_.b.centre), half_b = m_.frame.map().cwiseAbs() * m_.b.half;
    const Vec3 p = 0.5 * ((m_.a.centre - m_.a.half).cwiseMax(centre_b - half_b) +
                          (m_.a.centre + m_.a.half).cwiseMin(centre_b + half_b));
    const Reach r = reach_of_hulls(n_);
    return p + n_ * (0.5 * (r.high + r.low) - n_.dot(p));
  }

  bool holds(bool of_a, const Vec3& p) const {
    const Pose pose = of_a ? Pose{} : Pose{m_.frame.map(), m_.frame.shift()};
    return m_.mesh(of_a).solid && is_inside(m_.mesh(of_a), pose, p, Pose{}, m_.limit);
  }

  struct Component {
    double distance;  // of its nearest extreme vertex from the middle
    bool of_a;
    std::uint32_t number;
  };
  // An extreme vertex of a component inside the other mesh, and the middle of those of the component.
  struct Inner {
    Vec3 at, centre;
    bool of_a;
  };

  // The contact's place where one mesh lies inside the other: the middle of the boxes if it lies in both, else the
  // middle of the line along the normal inside both that begins at the nearest extreme vertex of a component inside,
  // else that vertex. A surface, or a solid about a hole, need not be near the middle of its box, and components may
  // lie apart.
  Vec3 place_in_both() {
    const Vec3 p = middle();
    if (holds(true, p) && holds(false, p)) return p;
    List<Inner> nearest = nearest_inside(p);
    if (nearest.empty()) return p;
    // Of equally near ones the first along the axes of the larger mesh, which no order of vertices or meshes changes.
    const bool by_a = m_.a.half.norm() >= m_.b.half.norm();
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = by_a ? Vec3(Vec3::Unit(k)) : Vec3(m_.frame.map().col(k));
      double most = -std::numeric_limits<double>::infinity();
      for (const Inner& i : nearest) most = std::max(most, axis.dot(i.at));
      const double least = most - tolerance::alike * (m_.a.half + m_.b.half).norm();
      const auto is_less = [&](const Inner& i) { return axis.dot(i.at) < least; };
      nearest.erase(std::remove_if(nearest.begin(), nearest.end(), is_less), nearest.end());
    }
    return middle_inside(nearest.front());
  }

  List<Inner> nearest_inside(const Vec3& p) {
    constexpr int of_test = 16;
    List<Component> order(memory_);
    List<Inner> nearest(memory_);
    for (const bool of_a : {true, false}) {
      std::uint32_t number = 0;
      for (const MeshModel::Component& component : m_.mesh(of_a).components(m_.limit)) {
        meter_.spend();
        double least = std::numeric_limits<double>::infinity();
        for (const std::uint32_t v : component) least = std::min(least, (m_.vertex(of_a, v) - p).norm());
        order.push_back({least, of_a, number++});
      }
    }
    std::sort(order.begin(), order.end(), [](const auto& x, const auto& y) { return x.distance < y.distance; });
    double farthest = std::numeric_limits<double>::infinity();
    for (const Component& c : order) {
      if (c.distance > farthest) break;
      meter_.spend(of_test);
      const MeshModel::Component& component = m_.mesh(c.of_a).components(m_.limit)[c.number];
      if (!holds(!c.of_a, m_.vertex(c.of_a, component[0]))) continue;
      farthest = std::min(farthest, c.distance + tolerance::alike * (m_.a.half + m_.b.half).norm());
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t v : component) sum += m_.vertex(c.of_a, v);
      for (const std::uint32_t v : component)
        if (const Vec3 at = m_.vertex(c.of_a, v); (at - p).norm() <= farthest)
          nearest.push_back({at, sum / static_cast<double>(component.size()), c.of_a});
    }
    return nearest;
  }

  // The middle of the line along the normal from a vertex inside both, if it enters both to one side; else the vertex.
  Vec3 middle_inside(const Inner& from) {
    if (!m_.mesh(from.of_a).solid) return from.at;
    for (const double side : {1.0, -1.0}) {
      double length = std::numeric_limits<double>::infinity();
      for (const bool of_a : {true, false}) length = std::min(length, length_inside(of_a, from.at, side * n_));
      if (!(length < std::numeric_limits<double>::infinity())) continue;
      const Vec3 at = from.at + 0.5 * length * side * n_;
      // It may run along an edge or a face: then what lies a little to one side decides.
      const Vec3 aside = slack_ * (from.centre - at).stableNormalized();
      for (const Vec3& inner : {at, Vec3(at + aside), Vec3(at - aside)})
        if (holds(true, inner) && holds(false, inner)) return at;
    }
    return from.at;
  }

  // The distance from a point along d (unit) to the mesh's surface that is next beyond slack_; infinity without one.
  double length_inside(bool of_a, const Vec3& from, const Vec3& d) {
    const MeshModel& mesh = m_.mesh(of_a);
    const Mat3 back = m_.frame.map().transpose();
    const Vec3 line = of_a ? d : Vec3(back * d), start = of_a ? from : Vec3(back * (from - m_.frame.shift()));
    const Vec3 at = (start - mesh.centre) / mesh.unit;
    const double pad = slack_ / mesh.unit + tolerance::no_extent;
    double least = std::numeric_limits<double>::infinity();
    const auto reaches = [&](const LaneBoxes& boxes, std::uint32_t k) {
      const auto vector_of = [k](const auto& of) -> Vec3 {
        return Eigen::Vector3f(of[0][k], of[1][k], of[2][k]).cast<double>();
      };
      const Vec3 to = vector_of(boxes.mid) - at;
      return (to - line.dot(to) * line).norm() <= vector_of(boxes.half).norm() + pad;
    };
    visit_triangles(mesh, meter_, reaches, [&](std::uint32_t triangle) {
      least = std::min(least, length_to(mesh.corners(triangle), start, line));
      return false;
    });
    return least;
  }

  // To a triangle, its border included; infinity beside it, along it and before slack_.
  double length_to(const std::array<Vec3, 3>& corners, const Vec3& from, const Vec3& d) const {
    const Vec3 area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double along = area.dot(d), length = area.dot(corners[0] - from) / along;
    if (!(std::abs(along) > tolerance::alike * area.norm()) || !(length > slack_))
      return std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = corners[k] - from, edge = corners[(k + 1) % 3] - corners[k];
      if (std::copysign(1.0, along) * d.dot(p.cross(edge)) < -slack_ * edge.norm())
        return std::numeric_limits<double>::infinity();
    }
    return length;
  }

  void take_direction_of_hulls() {
    double least = std::numeric_limits<double>::infinity();
    const auto consider_hulls = [&](const Vec3& n) {
      if (n.norm() < 0.5) return;
      const Reach r = reach_of_hulls(n);
      if (const double depth = r.high - r.low; depth < least - slack_) least = depth, n_ = n;
    };
    consider_hulls(faces_.sides());
    consider_hulls((m_.frame.in_a(m_.b.centre) - m_.a.centre).stableNormalized());
    for (int k = 0; k < 3; ++k)
      for (const double s : {1.0, -1.0}) {
        consider_hulls(s * Vec3::Unit(k));
        consider_hulls(s * m_.frame.map().col(k).normalized());
      }
    depth_ = faces_.size() == 0 ? std::max(least, 0.0) : faces_.deepest_along(n_);
  }

  const PosedMeshes& m_;
  const std::span<const TrianglePair> met_;  // they intersect; sorted
  const double slack_;                       // distance that counts as touching
  WorkMeter meter_;
  const Memory memory_;
  TouchingFaces faces_;  // those that intersect and near ones
  Vec3 n_;
  double depth_;  // of the intersecting triangles, along n
};

}  // namespace

void sort_contacts(std::span<Contact> contacts) {
  std::sort(contacts.begin(), contacts.end(), [](const Contact& x, const Contact& y) {
    if (x.feature != y.feature) return x.feature < y.feature;
    return std::lexicographical_compare(x.point.begin(), x.point.end(), y.point.begin(), y.point.end());
  });
}

void touching_contacts(const Posed& a, const Posed& b, const TriangleTest& frame, std::span<const TrianglePair> pairs,
                       const NarrowPhaseOptions& options, std::size_t first, std::vector<Contact>& contacts) {
  const PosedMeshes m{mesh_of(a.shape), mesh_of(b.shape), frame, false, false, options.limit};
  alignas(std::max_align_t) std::array<std::byte, usual_memory> usual;
  std::pmr::monotonic_buffer_resource memory(usual.data(), usual.size(), lent_memory(options));
  Touching touching(m, pairs, &memory);
  if (!touching.separable() && contacts.size() > first) return;
  contacts.resize(first);
  if (touching.separable()) touching.add_near(a, b);
  touching.append(contacts);
  sort_contacts(std::span(contacts).subspan(first));
}

}  // namespace tandem
