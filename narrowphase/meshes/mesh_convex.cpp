#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

#include "closed_forms/closed_forms.h"
#include "manifold/manifold.h"
#include "manifold/patch_collector.h"
#include "meshes/contacts/mesh_rim.h"
#include "meshes/depth/mesh_inside.h"
#include "meshes/depth/mesh_walls.h"
#include "meshes/mesh_pair.h"
#include "meshes/traversal/mesh_query.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

// What two pieces of rounding may make of nothing, relative to the size.
constexpr double rounding = tolerance::place_rounding;
// By how much a depth may be off that counts as certain, relative to the size: two such agree to 1e-12.
constexpr double certain_within = 3 * rounding;

Vec3 area_vector(const Corners& p) { return (p[1] - p[0]).cross(p[2] - p[0]); }

// A mesh and a bounded convex shape. Everything is computed with the mesh's axes about the convex's origin: far from
// the origin of either frame, nothing is lost.
class MeshConvex {
 public:
  MeshConvex(const Posed& mesh, const Posed& convex, const NarrowPhaseOptions& options)
      : mesh_(mesh),
        convex_(convex),
        model_(mesh_of(mesh.shape)),
        view_(convex.shape.is_convex() ? view(convex.shape) : view_hull(convex.shape)),
        options_(for_triangles(options)),
        size_(mesh.shape.size() + convex.shape.size()),
        margin_(options.margin),
        radius_(core_radius(view_)) {
    options_.margin += tolerance::alike * size_;
    const RelativePose r = relative(mesh.pose, convex.pose);
    turn_.rotation = r.rotation;
    shift_ = r.translation;
    const Bounds own = convex.shape.bounds(Pose{});
    own_mid_ = (own.lo + own.hi) / 2;
    own_half_ = (own.hi - own.lo) / 2;
    mid_ = turn_.rotation * own_mid_;
    if (!(radius_ > 0)) aligned_ = convex.shape.bounds(turn_);
  }

  bool collide() const {
    bool hit = false;
    Side clear;
    query().each_near(0, [&](std::uint32_t t) {
      const Corners p = corners(t);
      if (clear.beyond(p) > rounding * size_) return false;
      if (touches(p)) return hit = true;
      // What keeps it from this triangle keeps it from its neighbours as well, more often than not.
      if (view_.kind != ShapeKind::box) clear = side(solve(p, Request::distance, nullptr).normal);
      return false;
    });
    return hit || inside();
  }

  PairAnswer distance() const {
    const PairAnswer near = nearest();
    if (near.signed_distance > 0 && !inside()) return in_world(near);
    return in_world(overlap(near));
  }

  PairAnswer contacts(std::vector<Contact>& out) const {
    const std::size_t first = out.size();
    PairAnswer near;
    near.signed_distance = infinity;
    gather_contacts(infinity, near, out);
    decide(near);
    if (near.signed_distance <= 0) return contacts_of_overlap(near, first, out);
    // Where the shape lies inside, the gaps that were found are to the wrong side of the surface.
    if (inside()) {
      out.resize(first);
      const PairAnswer answer = distance();
      out.push_back(contact_of(answer));
      return answer;
    }
    return contacts_of_gap(near, first, out);
  }

 private:
  // ---- Frames ----

  Corners corners(std::uint32_t t) const {
    const auto& v = model_.triangles[t];
    return {model_.vertices[v[0]] - shift_, model_.vertices[v[1]] - shift_, model_.vertices[v[2]] - shift_};
  }
  Vec3 to_world(const Vec3& p) const { return mesh_.pose.rotation * p + convex_.pose.translation; }
  Vec3 turned(const Vec3& n) const { return (mesh_.pose.rotation * n).normalized(); }
  void to_world(std::span<Contact> contacts) const {
    for (Contact& c : contacts) {
      c.point = to_world(c.point);
      c.normal = turned(c.normal);
    }
  }
  PairAnswer in_world(PairAnswer r) const {
    r.point_a = to_world(r.point_a);
    r.point_b = to_world(r.point_b);
    r.normal = turned(r.normal);
    return r;
  }
  Vec3 own_centre() const { return view_.hull != nullptr ? view_.hull->inside : Vec3(0, 0, 0); }
  Vec3 centre() const { return turn_.rotation * own_centre(); }

  // The point of the convex farthest along d (unit).
  Vec3 support(const Vec3& d) const {
    return turn_.rotation * core_support(view_, turn_.rotation.transpose() * d) + radius_ * d;
  }

  BoxQuery query() const {
    if (radius_ > 0) {
      const Vec3 half(0, 0, own_half_.z() - radius_), along = (turn_.rotation * half).cwiseAbs();
      return {model_, {shift_ - along, shift_ + along}, shift_, half, turn_.rotation, radius_};
    }
    return {model_, shifted(aligned_, shift_), mid_ + shift_, own_half_, turn_.rotation};
  }
  static Bounds shifted(const Bounds& b, const Vec3& by) { return {b.lo + by, b.hi + by}; }

  // ---- One triangle ----

  PairAnswer solve(const Corners& p, Request request, std::vector<Contact>* contacts) const {
    if (view_.kind == ShapeKind::sphere && request == Request::distance) {
      const PointDistance d = point_distance(TriangleView(p), Vec3::Zero());
      PairAnswer r;
      r.signed_distance = d.signed_distance - radius_;
      r.collide = r.signed_distance <= 0;
      r.normal = d.normal;
      r.point_a = d.nearest;
      r.point_b = -radius_ * d.normal;
      return r;
    }
    return solve_convex(TriangleView(p), Pose{}, view_, turn_, request, options_, contacts);
  }

  // The plane that bounds the convex against a direction.
  struct Side {
    Vec3 normal = Vec3::Zero();  // towards the convex
    double low = -infinity;
    // How far a triangle lies beyond it.
    double beyond(const Corners& p) const { return low - highest(normal, p); }
  };
  static double highest(const Vec3& d, const Corners& p) { return std::max({d.dot(p[0]), d.dot(p[1]), d.dot(p[2])}); }
  Side side(const Vec3& normal) const { return {normal, normal.dot(support(-normal))}; }

  // A triangle along its normal. That of a sliver may be any direction, for rounding: what is said of heights holds
  // along whichever direction it is, what is said of a plane only where it is `flat`, all corners being at one height.
  struct Face {
    Vec3 normal = Vec3::Zero();  // unit; zero where there is no area at all
    double low = -infinity, high = infinity;
    bool flat = false;
  };
  Face face_of(const Corners& p) const {
    Face face;
    const Vec3 n = area_vector(p);
    const double length = n.norm();
    if (!(length > 0)) return face;
    face.normal = unit(n, length);
    std::tie(face.low, face.high) = std::minmax({face.normal.dot(p[0]), face.normal.dot(p[1]), face.normal.dot(p[2])});
    face.flat = face.high - face.low <= rounding * size_;
    return face;
  }

  // How far the box about the convex keeps from the triangle along the face's normal.
  double box_gap_along(const Face& face) const {
    const double middle = face.normal.dot(mid_);
    return std::max(face.low - middle, middle - face.high) -
           (turn_.rotation.transpose() * face.normal).cwiseAbs().dot(own_half_);
  }

  // How far the convex keeps from the triangle along the face's normal; a lower bound of the distance.
  double gap_along(const Face& face) const {
    const double gap = box_gap_along(face);
    if (gap > 0 || view_.kind == ShapeKind::box) return gap;
    const Vec3& n = face.normal;
    return face.low > n.dot(mid_) ? face.low - n.dot(support(n)) : n.dot(support(-n)) - face.high;
  }
  double plane_gap(const Corners& p) const { return gap_along(face_of(p)); }

  // The way off the triangle along its normal, to the nearer side: its depth is at most this.
  double way_off(const Corners& p) const {
    const Face face = face_of(p);
    const Vec3& n = face.normal;
    if (n.isZero()) return infinity;
    return std::min(n.dot(support(n)) - face.low, face.high - n.dot(support(-n)));
  }

  bool touches(const Corners& p) const {
    if (view_.kind != ShapeKind::sphere) {
      if (plane_gap(p) > rounding * size_) return false;
      if (view_.kind == ShapeKind::box) {
        const double gap = box_gap(p);
        if (std::abs(gap) > rounding * size_) return gap < 0;
      }
    }
    if (view_.kind == ShapeKind::sphere || view_.kind == ShapeKind::box)
      return solve(p, Request::distance, nullptr).signed_distance <= 0;
    return solve(p, Request::collide, nullptr).collide;
  }

  // Largest separation of box and triangle along their 13 axes (Akenine-Moeller, Fast 3D triangle-box overlap testing,
  // 2001): < 0 says that they overlap, a positive one that they are apart, 0 that they may: a sliver's normal is not
  // known well enough to tell.
  double box_gap(const Corners& p) const {
    const Mat3 to_box = turn_.rotation.transpose();
    const Corners q{to_box * p[0], to_box * p[1], to_box * p[2]};
    double gap = (q[0].cwiseMin(q[1]).cwiseMin(q[2]) - own_half_)
                     .cwiseMax(-own_half_ - q[0].cwiseMax(q[1]).cwiseMax(q[2]))
                     .maxCoeff();
    if (gap > rounding * size_) return gap;
    for (std::size_t e = 0; e < 3; ++e) {
      const Vec3 edge = q[(e + 1) % 3] - q[e];
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        // Axis i x edge: (.., -edge[k], edge[j]).
        const double length = std::hypot(edge[j], edge[k]);
        if (!(length > 0)) continue;
        const double extent = own_half_[j] * std::abs(edge[k]) + own_half_[k] * std::abs(edge[j]);
        const auto at = [&](const Vec3& v) { return edge[j] * v[k] - edge[k] * v[j]; };
        const double a = at(q[e]), b = at(q[(e + 2) % 3]);
        gap = std::max(gap, (std::max(std::min(a, b), -std::max(a, b)) - extent) / length);
        if (gap > rounding * size_) return gap;
      }
    }
    const Face face = face_of(p);
    return std::max(gap, face.flat ? gap_along(face) : std::max(0.0, gap_along(face)));
  }

  // ---- All of them ----

  // At distances that may be rounding's doing the verdict is that of `collide`.
  void decide(PairAnswer& near) const {
    if (!(std::abs(near.signed_distance) <= rounding * size_)) return;
    near.collide = collide();
    near.signed_distance = near.collide ? std::min(near.signed_distance, 0.0)
                                        : std::max(near.signed_distance, std::numeric_limits<double>::min());
  }

  // The nearest triangle's answer; any that overlaps will do.
  PairAnswer nearest() const {
    PairAnswer best;
    best.signed_distance = infinity;
    Side clear;
    query().nearest_first(infinity, [&](std::uint32_t t) {
      if (best.signed_distance <= 0) return -1.0;
      const Corners p = corners(t);
      if (clear.beyond(p) >= best.signed_distance || plane_gap(p) >= best.signed_distance) return best.signed_distance;
      const PairAnswer r = solve(p, Request::distance, nullptr);
      if (r.signed_distance < best.signed_distance) {
        best = r;
        clear = side(best.normal);
      }
      return best.signed_distance;
    });
    decide(best);
    return best;
  }

  bool inside() const { return model_.solid && is_inside(model_, mesh_.pose, own_centre(), convex_.pose); }

  // ---- Overlap ----

  Pose moved(const Vec3& by) const {
    return {convex_.pose.rotation, convex_.pose.translation + mesh_.pose.rotation * by};
  }

  // Is a way out free a little farther on, too? At its end what it leaves and what comes next may touch both, and
  // rounding say that neither does.
  bool goes_on(double way, const Vec3& normal) const {
    return !MeshConvex(mesh_, {convex_.shape, moved((way + tolerance::alike * size_) * normal)}, options_).collide();
  }

  // Least way along d (unit) that was found to separate, as planes across d push the convex off one layer of triangles
  // after the other; infinity if it comes to more than `most`.
  double way_out(const Vec3& d, double most) const {
    constexpr int layers = 64;
    const double low = d.dot(support(-d)), clearance = 10 * rounding * size_;  // past what only touches
    double way = 0;
    for (int i = 0; i < layers; ++i) {
      const Pose at = moved((way + clearance) * d);
      const MeshConvex there(mesh_, {convex_.shape, at}, options_);
      double next = -infinity;
      there.query().each_near(0, [&](std::uint32_t t) {
        const Corners p = there.corners(t);
        const double level = std::max({d.dot(p[0]), d.dot(p[1]), d.dot(p[2])}) - low;
        if (level > next && there.touches(p)) next = level;
        return way + next > most;
      });
      if (next == -infinity) {
        if (there.inside()) {
          next = first_crossing(model_, there.shift_ + there.centre(), d);
        } else {
          if (goes_on(way, d)) return way;
          next = tolerance::alike * size_;
        }
      }
      way += std::max(clearance + next, rounding * size_);
      if (!(way < most)) return infinity;
    }
    return infinity;
  }

  // The walls that part the convex, moved by `at`, from every triangle less than `reach` away: whatever translation no
  // farther than that from `at` lies beyond them keeps it parted. False: it touches one, or they are too many.
  bool walls_about(const Vec3& at, double reach, std::vector<Wall>& walls) const {
    constexpr std::size_t most = 48;
    const Pose pose = moved(at);
    const MeshConvex there(mesh_, {convex_.shape, pose}, options_);
    struct Known {
      Side side;
      double gap;
    };
    std::vector<Known> known;
    walls.clear();
    bool parted = true;
    there.query().each_near(reach, [&](std::uint32_t t) {
      const Corners p = there.corners(t);
      if (std::any_of(known.begin(), known.end(), [&](const Known& k) { return k.side.beyond(p) >= k.gap; }))
        return false;
      const PairAnswer r = there.solve(p, Request::distance, nullptr);
      if (r.signed_distance > reach) return false;
      const Side own = there.side(r.normal);
      const double gap = own.beyond(p);
      if (!(r.signed_distance > 0 && gap > 0) || walls.size() == most) {
        parted = false;
        return true;
      }
      known.push_back({own, gap});
      walls.push_back({r.normal, r.normal.dot(at) - gap});
      return false;
    });
    return parted;
  }

  // Makes a free way shorter, by the shortest one beyond the walls about it, again and again: down to a way that
  // nothing near it is shorter than.
  void shorten(double& way, Vec3& normal) const {
    constexpr int rounds = 8;
    const double before = way, slack = rounding * size_;
    const Vec3 along = normal;
    std::vector<Wall> walls;
    double out = tolerance::far_apart * size_;
    for (int i = 0; i < rounds; ++i, out = std::max(0.1 * out, tolerance::least_apart * size_)) {
      Vec3 shortest;
      if (!walls_about((way + out) * normal, way + out, walls) || !shortest_beyond(walls, slack, shortest)) break;
      const double length = shortest.norm();
      if (!(length > 0 && length < way - slack)) break;
      way = length;
      normal = unit(shortest, length);
    }
    if (way < before && !goes_on(way, normal)) way = before, normal = along;
  }

  // A depth no translation can be less than, and the direction that asks for it.
  struct Certain {
    double depth = 0;
    Vec3 out = Vec3::Zero();
  };

  // By a point of the convex that has a ball of it about it: where `leaves`, no way out ends inside.
  Certain deep_at(const Vec3& p, double ball, bool leaves) const {
    const Vec3 local = p + shift_;
    const SurfacePoint near = nearest_point(model_, local);
    const Vec3 out = near.distance > 0 ? unit(near.at - local, near.distance) : Vec3::Zero();
    if (leaves && is_inside(model_, local)) return {ball + near.distance, out};
    return {ball - near.distance, -out};
  }

  // Does every way out that is no longer than this lead out of the closed surface, not into it? A point of the convex
  // farther outside stays there, and the rest with it. A way that leads in is, but for rounding, as long as the
  // farthest point is outside.
  bool leaves_within(double way, const Vec3& normal) const {
    if (model_.solid) return true;
    if (!model_.closed || !std::isfinite(way)) return false;
    for (const Vec3& p : {centre(), support(normal)})
      if (nearest_point(model_, p + shift_).distance > way + 10 * rounding * size_ && !is_inside(model_, p + shift_))
        return true;
    return false;
  }

  Certain certain_depth(const Vec3& normal, bool leaves) const {
    constexpr std::size_t most_corners = 32;
    Certain certain = deep_at(centre(), core_radius(view_) + core_inner_radius(view_), leaves);
    if (view_.kind == ShapeKind::sphere) return certain;
    const auto look = [&](const Vec3& p, double ball) {
      if (const Certain here = deep_at(p, ball, leaves); here.depth > certain.depth) certain = here;
    };
    look(support(-normal), 0);
    if (view_.kind == ShapeKind::capsule)
      for (const double s : {-0.5, 0.5}) look(turn_.rotation.col(2) * (s * view_.param[1]), radius_);
    if (!leaves) return certain;
    if (view_.kind == ShapeKind::box)
      for (unsigned i = 0; i < 8; ++i) {
        const Vec3 s(i & 1u ? 1 : -1, i & 2u ? 1 : -1, i & 4u ? 1 : -1);
        look(turn_.rotation * s.cwiseProduct(own_half_), 0);
      }
    if (view_.hull != nullptr && view_.vertices.size() <= most_corners)
      for (const Vec3& v : view_.vertices) look(turn_.rotation * v, 0);
    return certain;
  }

  // The walls of the triangles that the convex, moved by `at`, reaches through. A chord of it, from its deepest point
  // over the triangle to its centre, goes through the triangle; moved by less than the chord's end is above the plane,
  // and by less than would take the crossing beyond the triangle's edges, it still does until its deepest point comes
  // up. Of alike walls the highest is kept. False: none was added.
  bool add_holds(const Vec3& at, std::vector<Hold>& holds) const {
    constexpr std::size_t most = 48;
    const double slack = rounding * size_;
    const MeshConvex there(mesh_, {convex_.shape, moved(at)}, options_);
    std::vector<Contact> points;
    bool added = false;
    there.query().each_near(0, [&](std::uint32_t t) {
      const Corners p = there.corners(t);
      const Face face = there.face_of(p);
      if (!face.flat) return false;
      Vec3 n = face.normal;
      double height = n.dot(centre() - p[0]);
      if (height < 0 && model_.solid) return false;
      if (height < 0) n = -n, height = -height;
      const Vec3 lowest = there.support(-n);
      const double depth = n.dot(p[0] - lowest);
      if (!(depth > 0)) return false;
      const auto known =
          std::find_if(holds.begin(), holds.end(), [&](const Hold& h) { return h.wall.normal.dot(n) > tolerance::one_direction; });
      constexpr double ample = 16;
      if (known != holds.end() && known->wall.bound >= n.dot(at) + depth - slack && known->reach > ample * depth)
        return false;
      // The middle of what is deepest over the triangle.
      points.clear();
      there.append_points(p, {-depth, lowest + depth * n, lowest, n, 0}, points);
      double deepest = -infinity;
      for (const Contact& c : points) deepest = std::max(deepest, c.depth);
      Vec3 low = Vec3::Zero();
      double count = 0;
      for (const Contact& c : points)
        if (c.depth >= deepest - slack) low += c.point - (0.5 * c.depth) * n, ++count;
      if (!(count > 0)) return false;
      low /= count;
      const double below = n.dot(p[0] - low);
      const Vec3 chord = centre() - low;
      const double rise = n.dot(chord), slope = rise / chord.norm();
      if (!(below > 0 && rise > 0)) return false;
      const Vec3 through = low + (below / rise) * chord;
      const double inside = flat_about(model_, t, through + there.shift_, slack);
      if (!(inside > 0)) return false;
      const Hold hold{{n, n.dot(at) + below}, std::min(height, inside * slope) - at.norm()};
      if (known == holds.end()) {
        if (holds.size() < most) holds.push_back(hold), added = true;
      } else if (hold.wall.bound > known->wall.bound + slack ||
                 (hold.wall.bound > known->wall.bound - slack && hold.reach > known->reach)) {
        *known = hold;
        added = true;
      }
      return false;
    });
    return added;
  }

  // The shortest way out between walls of which no one alone says what it is, as of a corner of a room: taken if it is
  // shorter than `way` and free. Returns a depth that is certain.
  double leave_walls(double& way, Vec3& normal) const {
    constexpr int rounds = 8;
    const double slack = rounding * size_;
    std::vector<Hold> holds;
    std::vector<Wall> walls;
    Vec3 at = Vec3::Zero(), shortest;
    for (int i = 0; i < rounds && add_holds(at, holds); ++i) {
      walls.clear();
      for (const Hold& h : holds) walls.push_back({h.wall.normal, h.wall.bound + slack});
      if (!shortest_beyond(walls, slack / 8, at) || !(at.norm() < way)) break;
      if (MeshConvex(mesh_, {convex_.shape, moved(at)}, options_).collide()) continue;
      for (Wall& wall : walls) wall.bound -= slack;
      if (!shortest_beyond(walls, slack / 8, shortest)) break;
      const double length = shortest.norm();
      const Vec3 along = unit(at, at.norm());
      if (goes_on(length, along)) way = length, normal = along;
      break;
    }
    // Of these only those count that hold so far.
    const auto certain_to = [&](double far) {
      walls.clear();
      for (const Hold& h : holds)
        if (h.reach >= far) walls.push_back(h.wall);
      return shortest_beyond(walls, slack / 8, shortest) ? std::min(far, shortest.norm()) : 0;
    };
    return std::isfinite(way) ? certain_to(way) : 0;
  }

  // The answer in local coordinates for an overlap; `near` is the nearest triangle's.
  PairAnswer overlap(const PairAnswer& near) const {
    constexpr std::size_t most_directions = 5;
    const double enough = rounding * 10 * size_;
    PairAnswer deepest = near;
    double certain = 0, way = infinity;
    Vec3 normal = near.normal;
    std::vector<Vec3> tried, faces;
    Side clear;
    const auto attempt = [&](const Vec3& d, double alike = 0.9999) {
      if (way <= certain + enough || !(d.norm() > 0.5)) return;
      if (std::any_of(tried.begin(), tried.end(), [&](const Vec3& o) { return o.dot(d) > alike; })) return;
      tried.push_back(d);
      if (const double w = way_out(d, way); w < way) way = w, normal = d;
    };
    if (near.signed_distance > 0) {
      certain = near.signed_distance;
      attempt(-near.normal);  // out through the nearest wall
    } else {
      query().each_near(0, [&](std::uint32_t t) {
        const Corners p = corners(t);
        const double gap = plane_gap(p);
        if (gap > 0) return false;
        // No deeper than along a direction that is known to part them.
        if (-clear.beyond(p) <= certain || way_off(p) <= certain) return false;
        if (view_.kind == ShapeKind::box && box_gap(p) > 0) return false;
        const PairAnswer r = solve(p, Request::distance, nullptr);
        if (r.signed_distance > 0) return false;
        if (-r.signed_distance >= certain) {
          certain = -r.signed_distance;
          deepest = r;
          clear = side(r.normal);
        }
        const Vec3 n = area_vector(p).stableNormalized();
        faces.push_back(model_.solid || n.dot(centre() - p[0]) >= 0 ? n : Vec3(-n));
        return false;
      });
      attempt(deepest.normal);
      if (way > certain + enough) certain = std::max(certain, leave_walls(way, normal));
    }
    const auto look = [&](const Vec3& n) {
      if (!(way > certain + enough)) return;
      const Certain deep = certain_depth(n, leaves_within(way, n));
      certain = std::max(certain, deep.depth);
      attempt(deep.out);
    };
    look(tried.empty() ? normal : tried[0]);
    for (const Vec3& n : faces)
      if (tried.size() < most_directions) attempt(n, 0.95);
    // Deep inside, what separates from the hull may be as good as any.
    if (way > certain + enough && way > 0.1 * std::min(mesh_.shape.size(), convex_.shape.size()) &&
        model_.hull.dimension == 3)
      attempt(mesh_.pose.rotation.transpose() * solve_convex(view_hull(mesh_.shape), mesh_.pose, view_, convex_.pose,
                                                             Request::distance, options_, nullptr)
                                                    .normal);
    // Where it comes free, the surfaces' normal is a better way out.
    constexpr int most_turns = 6;
    for (int i = 0; i < most_turns && way > certain + enough && std::isfinite(way); ++i) {
      const Pose at = moved((way + tolerance::far_apart * size_) * normal);
      const PairAnswer r = MeshConvex(mesh_, {convex_.shape, at}, options_).nearest();
      if (!(r.signed_distance > 0) || r.normal.dot(normal) > tolerance::no_turn) break;
      const double before = way;
      attempt(r.normal);
      if (!(way < before * (1 - tolerance::no_shorter))) break;
    }
    if (way > certain + enough && std::isfinite(way)) {
      shorten(way, normal);
      const double before = way;
      look(normal);
      if (way < before && way > certain + enough) shorten(way, normal);
    }
    PairAnswer answer;
    answer.collide = true;
    if (!std::isfinite(way)) {  // no way tried was free: beyond the whole mesh it is
      way = -infinity;
      for (const std::uint32_t v : model_.extreme) way = std::max(way, normal.dot(model_.vertices[v] - shift_));
      way -= normal.dot(support(-normal));
    }
    if (way > certain + enough) {
      answer.status = Status::inexact;
      answer.error_bound = way - certain;
    } else {
      way = certain;  // without the steps that rounding asked for
    }
    answer.signed_distance = -way;
    answer.normal = normal;
    // Where they part: on the mesh there, and the same point of the convex where it is now.
    const PairAnswer r = MeshConvex(mesh_, {convex_.shape, moved(way * normal)}, options_).nearest();
    answer.point_a = r.point_a + way * normal;
    answer.point_b = answer.point_a - way * normal;
    return answer;
  }

  // ---- Contacts ----

  // Is the way off the triangle's plane to the side of the convex's centre, along n (unit), provably the shortest? The
  // point that is deepest, w below the plane, lies over the triangle at least rho from its edges. So a disc of it
  // holds the convex back along any direction at an angle x to n by w cos x + rho sin x, which is less than w only
  // beyond pi - 2 atan(w / rho). There the centre, h above the plane and l away from the deepest point along it, holds
  // it back by -h cos x - l sin x. Apart, the deepest point need only lie over the triangle.
  bool faces_convex(const Corners& p, const Vec3& n, const Vec3& deepest, double w) const {
    double rho2 = infinity;
    const double turn = n.dot(area_vector(p)) > 0 ? 1 : -1;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 edge = p[(i + 1) % 3] - p[i];
      const double beside = turn * n.cross(edge).dot(deepest - p[i]), length2 = edge.squaredNorm();
      if (!(beside > 0)) return false;
      if (w > 0 && !(beside * beside > 16 * w * w * length2)) return false;
      rho2 = std::min(rho2, beside * beside / length2);
    }
    if (!(w > 0)) return true;
    const Vec3 up = centre() - deepest;
    const double k2 = w * w / rho2, h = up.dot(n) - w, l2 = (up - up.dot(n) * n).squaredNorm();
    const double spare = h * (1 - k2) - w * (1 + k2);
    return spare > 0 && spare * spare > 4 * k2 * l2;
  }

  // How far apart a triangle and the convex are known to be, and along which normal; zero where that is its own.
  struct Apart {
    double gap;
    Vec3 normal = Vec3::Zero();
  };

  // All of a triangle's: those that span the patch are chosen from all triangles' together.
  void append_points(const Corners& p, const LocalAnswer& answer, std::vector<Contact>& found) const {
    constexpr bool whole = true;
    append_manifold(TriangleView(p), view_, {turn_.rotation, Vec3::Zero()}, answer, options_.margin, Pose{}, found,
                    whole);
  }

  // Do all of the points lie on an edge or a corner of the triangle beyond which its neighbours reach farther along n?
  bool is_at_edge_of_more(std::uint32_t t, const Corners& p, const Vec3& n, std::span<const Contact> points) const {
    const double slack = tolerance::alike * size_;
    const auto all = [&](auto&& are_there) {
      return std::all_of(points.begin(), points.end(), [&](const Contact& c) { return are_there(c.point); });
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &from = p[k], &to = p[(k + 1) % 3];
      if (all([&](const Vec3& q) { return (q - from).norm() <= slack; })) return overtopped(model_, t, k, n);
      const std::uint32_t next = model_.neighbours[t][k];
      if (next == no_index || highest(n, corners(next)) - std::max(n.dot(from), n.dot(to)) <= slack) continue;
      const Vec3 along = (to - from).stableNormalized();
      if (all([&](const Vec3& q) { return (q - from).cross(along).norm() <= slack; })) return true;
    }
    return false;
  }

  static Contact contact_of(const PairAnswer& r) {
    return {(r.point_a + r.point_b) / 2, r.normal, -r.signed_distance, 0};
  }

  // Adds the triangle's contacts but those deeper than `limit`; `near` is the nearest triangle's answer. `room`: what
  // it holds stays as it is.
  Apart add_contacts(std::uint32_t t, const Corners& p, double limit, PairAnswer& near, PatchCollector& patches,
                     std::vector<Contact>& room) const {
    const std::size_t first = room.size();
    const Apart apart = find_contacts(t, p, near, room, first);
    const auto is_too_deep = [&](const Contact& c) { return c.depth > limit; };
    room.erase(std::remove_if(room.begin() + static_cast<std::ptrdiff_t>(first), room.end(), is_too_deep), room.end());
    if (room.size() > first) patches.add(t, std::span<const Contact>(room).subspan(first));
    room.resize(first);
    return apart;
  }

  // The triangle's contacts, appended to `found`, which holds `first` of others.
  Apart find_contacts(std::uint32_t t, const Corners& p, PairAnswer& near, std::vector<Contact>& found,
                      std::size_t first) const {
    const Face face = face_of(p);
    if (const double gap = box_gap_along(face); gap > options_.margin) return {gap};
    PairAnswer r;
    bool is_known = false;
    if (face.flat) {
      const Vec3 n = face.normal.dot(centre() - p[0]) < 0 ? Vec3(-face.normal) : face.normal;
      const Vec3 deepest = support(-n);
      const double depth = n.dot(p[0] - deepest);
      if (depth < -options_.margin) return {-depth};
      is_known = view_.kind != ShapeKind::sphere && faces_convex(p, n, deepest, depth);
      if (is_known) {
        r.signed_distance = -depth;
        r.normal = n;
        r.point_a = deepest + depth * n;
        r.point_b = deepest;
      }
    }
    if (!is_known) r = solve(p, Request::contacts, nullptr);
    append_points(p, {r.signed_distance, r.point_a, r.point_b, r.normal, 0}, found);
    if (r.signed_distance < near.signed_distance) near = r;
    const Apart apart{r.signed_distance, r.normal};
    if (found.size() == first) return apart;
    const bool outward = !model_.solid || !face.flat || r.normal.dot(face.normal) > -tolerance::flush;
    // What only touches is pushed by the neighbours where it lies behind the face, or where they go on along the way.
    const bool pushes = outward &&
                        !(r.signed_distance >= -tolerance::alike * size_ &&
                          is_at_edge_of_more(t, p, r.normal, std::span<const Contact>(found).subspan(first))) &&
                        bears(model_, t, r.normal, r.point_a + shift_, tolerance::alike * size_);
    if (pushes) return apart;
    // Not a way the surface pushes: its neighbours lie there. What the face bears counts of what has gone through it.
    found.resize(first);
    if (face.flat && r.signed_distance < -tolerance::alike * size_) append_face_contacts(p, face, r.normal, found);
    return apart;
  }

  // Those along the face's normal, to the outer side; of a surface to that of the convex's centre.
  void append_face_contacts(const Corners& p, const Face& face, const Vec3& normal, std::vector<Contact>& found) const {
    const std::size_t first = found.size();
    const double side = face.normal.dot(centre() - p[0]);
    const bool as_wound = model_.solid || side > 0 || (side == 0 && face.normal.dot(normal) >= 0);
    const Vec3 n = as_wound ? face.normal : Vec3(-face.normal);
    const Vec3 low = support(-n);
    const double depth = n.dot(p[0] - low);
    if (depth < -options_.margin) return;
    const LocalAnswer along_face{-depth, low + depth * n, low, n, 0};
    append_points(p, along_face, found);
    if (point_distance(TriangleView(p), along_face.point_a).signed_distance <= tolerance::in_plane * size_) return;
    const auto is_made_up = [](const Contact& c) { return c.feature == 0xffffffffu; };
    found.erase(std::remove_if(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(), is_made_up),
                found.end());
  }

  // Appends those of all triangles, in local coordinates, but what is deeper than `limit`; `near` is the answer of the
  // nearest triangle within the margin, if that is nearer than what it was.
  void gather_contacts(double limit, PairAnswer& near, std::vector<Contact>& out) const {
    PatchCollector patches(size_);
    const std::size_t first = out.size();
    // What keeps it from one triangle keeps it from others near that.
    std::array<Side, 4> clear;
    std::size_t next = 0;
    query().each_near(options_.margin, [&](std::uint32_t t) {
      const Corners p = corners(t);
      for (const Side& known : clear)
        if (known.beyond(p) > options_.margin + rounding * size_) return false;
      const Apart apart = add_contacts(t, p, limit, near, patches, out);
      if (apart.gap > options_.margin && !apart.normal.isZero()) clear[next++ % clear.size()] = side(apart.normal);
      return false;
    });
    patches.finish(centre(), model_.solid, out);
    for (Contact& c : std::span(out).subspan(first)) c.depth = std::max(c.depth, -margin_);
  }

  static double deepest_of(std::span<const Contact> contacts) {
    double deepest = -infinity;
    for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
    return deepest;
  }

  // Of two that are apart by `near`: no contact is nearer, and one is as near.
  PairAnswer contacts_of_gap(const PairAnswer& near, std::size_t first, std::vector<Contact>& out) const {
    if (near.signed_distance > margin_) {
      out.resize(first);
      return {};
    }
    const double gap = near.signed_distance;
    for (Contact& c : std::span(out).subspan(first)) c.depth = std::min(c.depth, -gap);
    if (!(deepest_of(std::span(out).subspan(first)) >= -gap - rounding * size_)) out.push_back(contact_of(near));
    to_world(std::span(out).subspan(first));
    PairAnswer answer = from_deepest(out, first);
    answer.collide = false;
    return answer;
  }

  // Of triangles that overlap, the deepest by `near`: no shorter translation separates. Where a contact is that deep
  // and none is deeper, moving by it is tried; else the translation that separates is looked for, and what is deeper
  // than that does not push.
  PairAnswer contacts_of_overlap(const PairAnswer& near, std::size_t first, std::vector<Contact>& out) const {
    const auto deepest = [&] { return deepest_of(std::span(out).subspan(first)); };
    double certain = -near.signed_distance, shortest = infinity;
    const double slack = 10 * rounding * size_ + tolerance::no_shorter * certain;
    const auto find_shortest = [&] {
      const PairAnswer translation = overlap(nearest());
      shortest = -translation.signed_distance;
      certain = std::max(certain, shortest - translation.error_bound);
      return translation;
    };
    if (!(std::abs(deepest() - certain) <= slack)) {
      const PairAnswer translation = find_shortest();
      if (deepest() > shortest + slack) {
        out.resize(first);
        PairAnswer again = near;
        gather_contacts(shortest + slack, again, out);
      }
      if (!(deepest() >= certain - slack)) out.push_back(contact_of(translation));
    }
    to_world(std::span(out).subspan(first));
    PairAnswer answer = from_deepest(out, first);
    answer.collide = true;
    const double depth = -answer.signed_distance;
    bool separates = true;
    if (size_ == 0) return answer;  // two points in one place: any translation separates
    if (options_.mesh_bounds) {
      separates = !collides_moved((depth + 10 * rounding * size_) * answer.normal);
      if (!separates && std::isinf(shortest)) find_shortest();
    } else if (std::isinf(shortest)) {
      answer.status = Status::unproven;
    }
    const double off = std::max(depth - certain, std::isinf(shortest) ? 0.0 : shortest - depth);
    if (off > certain_within * size_ || !separates) {
      answer.status = Status::inexact;
      answer.error_bound = std::max(off, slack);
    }
    return answer;
  }

  // Do the two collide with the convex moved (world axes)?
  bool collides_moved(const Vec3& move) const {
    const Pose moved{convex_.pose.rotation, convex_.pose.translation + move};
    return MeshConvex(mesh_, {convex_.shape, moved}, options_).collide();
  }

  const Posed mesh_, convex_;
  const MeshModel& model_;
  const ConvexView view_;
  NarrowPhaseOptions options_;  // the margin widened: of two faces that touch to rounding no triangle is left out
  const double size_, margin_, radius_;
  Pose turn_;                      // of the convex; its origin is the origin
  Vec3 shift_;                     // of the mesh's frame: subtract it from vertices
  Bounds aligned_;                 // of the convex along the mesh's axes
  Vec3 mid_, own_mid_, own_half_;  // of its box, along its own axes
};

}  // namespace

PairAnswer solve_mesh_convex(const Posed& mesh, const Posed& convex, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts) {
  const MeshModel& model = mesh_of(mesh.shape);
  constexpr std::size_t small_hull = 64;
  if (model.convex && (model.hull.vertices.size() <= small_hull || request == Request::contacts))
    return solve_convex(view_hull(mesh.shape), mesh.pose, view(convex.shape), convex.pose, request,
                        for_triangles(options), contacts);
  // Seen from the mesh's translation: far out, poses that are tried would be rounded.
  const Vec3& origin = mesh.pose.translation;
  const Pose at{mesh.pose.rotation, Vec3::Zero()}, convex_at{convex.pose.rotation, convex.pose.translation - origin};
  const MeshConvex pair({mesh.shape, at}, {convex.shape, convex_at}, options);
  PairAnswer answer;
  if (request == Request::collide) {
    answer.collide = pair.collide();
    return answer;
  }
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  answer = request == Request::contacts ? pair.contacts(*contacts) : pair.distance();
  answer.point_a += origin;
  answer.point_b += origin;
  if (request == Request::contacts)
    for (Contact& c : std::span(*contacts).subspan(first)) c.point += origin;
  return answer;
}

}  // namespace tandem
