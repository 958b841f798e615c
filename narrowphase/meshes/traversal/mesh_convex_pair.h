// A mesh and a bounded convex shape, triangle by triangle: which come near it, which touch it, the nearest.
#pragma once
#include <algorithm>
#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "meshes/traversal/mesh_query.h"
#include "meshes/traversal/triangle_screen.h"
#include "shapes/posed_mesh.h"
#include "shapes/support.h"
#include "shapes/undecided.h"
#include "shapes/unit_vector.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"
#include "tolerances.h"

namespace tandem {

/// The plane that bounds the convex shape against a direction.
struct SupportPlane {
  Vec3 normal = Vec3::Zero();  ///< towards the convex shape
  double low = -infinity;
  /// How far a triangle lies beyond it.
  double beyond(const Corners& p) const { return low - most_along(normal, p); }
};

/// The last few planes that kept triangles apart from the convex shape: each keeps others near its own apart as well,
/// more often than not.
class ClearPlanes {
 public:
  void add(const SupportPlane& plane) { planes_[next_++ % planes_.size()] = plane; }
  bool separate(const Corners& p, double gap) const {
    const auto end = planes_.begin() + static_cast<std::ptrdiff_t>(std::min(next_, planes_.size()));
    return std::any_of(planes_.begin(), end, [&](const SupportPlane& s) { return s.beyond(p) > gap; });
  }

 private:
  std::array<SupportPlane, 4> planes_;
  std::size_t next_ = 0;
};

/// A triangle along its normal. That of a sliver may be any direction, for rounding: what is said of heights holds
/// along whichever direction it is, what is said of a plane only where it is `flat`, all corners being at one height.
struct TrianglePlane {
  Vec3 normal = Vec3::Zero();  ///< unit; zero where there is no area at all
  double low = -infinity, high = infinity;
  bool flat = false;
};

/// What a point of a triangle tells of it and the convex shape.
struct TriangleBound {
  bool known = false;     ///< false: there is no such bound for this shape, and nothing below is set
  bool overlaps = false;  ///< for sure: the point is inside
  /// The translation along the normal that takes the point out takes all of the triangle out: no shorter one does.
  bool is_depth = false;
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit, towards the convex shape
  double gap = -infinity;      ///< along it, a lower bound of the distance; negative: minus the length of a translation
                               ///< that separates
  double depth = -infinity;    ///< of the point below the surface: no translation shorter than this separates
};

/// Everything is computed with the mesh's axes about the convex shape's origin: far from the origin of either frame,
/// nothing is lost.
class MeshConvexPair {
 public:
  /// Options are those of a triangle and the convex shape; all arguments must outlive this.
  MeshConvexPair(const Posed& mesh, const Posed& convex, const NarrowPhaseOptions& options);

  /// This pair with the convex shape moved (mesh's axes), or elsewhere (world).
  MeshConvexPair moved(const Vec3& by) const {
    return placed({convex_pose_.rotation, convex_pose_.translation + mesh_.pose.rotation * by});
  }
  MeshConvexPair placed(const Pose& convex_pose) const;

  const MeshModel& model() const { return model_; }
  const ConvexView& convex() const { return view_; }
  double size() const { return size_; }      ///< of both, metres
  double radius() const { return radius_; }  ///< of the ball about each point of the convex shape's core
  /// What two pieces of rounding may make of nothing, metres.
  double slack() const { return tolerance::place_rounding * size_; }
  /// Up to this distance rounding may decide whether they touch, metres: vertices may be far from their own origin.
  double undecided() const { return undecided_distance(mesh_.shape, mesh_.pose, convex_shape_, convex_pose_); }
  /// What a translation that separates may be longer than the depth, metres.
  double translation_slack() const { return tolerance::translation_slack * size_; }
  const NarrowPhaseOptions& options() const { return options_; }
  const Posed& mesh() const { return mesh_; }
  Posed posed_convex() const { return {convex_shape_, convex_pose_}; }

  // ---- Frames

  Corners corners(std::uint32_t t) const {
    const auto& v = model_.triangles[t];
    return {model_.vertices[v[0]] - shift_, model_.vertices[v[1]] - shift_, model_.vertices[v[2]] - shift_};
  }
  Vec3 vertex(std::uint32_t v) const { return model_.vertices[v] - shift_; }
  Vec3 in_mesh(const Vec3& p) const { return p + shift_; }  ///< a point in the mesh's frame
  Vec3 to_world(const Vec3& p) const { return mesh_.pose.rotation * p + convex_pose_.translation; }
  Vec3 direction_to_world(const Vec3& n) const { return (mesh_.pose.rotation * n).normalized(); }
  const Mat3& turn() const { return turn_.rotation; }  ///< of the convex shape; its origin is the origin
  Vec3 centre() const { return turn_.rotation * own_centre(); }
  const Vec3& box_half() const { return own_half_; }  ///< of the convex shape's box along its own axes

  // ---- The convex shape along a direction

  /// Its point farthest along d (unit).
  Vec3 support(const Vec3& d) const {
    return turn_.rotation * core_support(view_, turn_.rotation.transpose() * d) + radius_ * d;
  }
  SupportPlane support_plane(const Vec3& normal) const { return {normal, normal.dot(support(-normal))}; }

  // ---- One triangle

  PairAnswer solve(const Corners& p, Request request) const;
  bool touches(const Corners& p) const { return touches(p, bound(p), nullptr); }
  /// `apart_along`: set to a normal (unit, towards the convex shape) along which they are apart, where one was found.
  bool touches(const Corners& p, const TriangleBound& bound, Vec3* apart_along) const;
  /// By a point of the triangle, without iterations.
  TriangleBound bound(const Corners& p, const Vec3& point) const;
  /// By its middle, and where that leaves it open whether they overlap, by points between it and the convex shape; of
  /// an ellipsoid by the point that is farthest inside.
  TriangleBound bound(const Corners& p) const;
  /// How far it is out of the convex shape from a point that is inside, along d (unit).
  double exit_length(const Vec3& point, const Vec3& d) const;

  /// Appends all contacts of a triangle with this answer, not only those that span the patch.
  void append_patch(const Corners& p, const LocalAnswer& answer, std::vector<Contact>& contacts) const;

  TrianglePlane plane_of(const Corners& p) const {
    TrianglePlane plane;
    const Vec3 n = area_vector(p);
    const double length = n.norm();
    if (!(length > 0)) return plane;
    plane.normal = unit(n, length);
    std::tie(plane.low, plane.high) =
        std::minmax({plane.normal.dot(p[0]), plane.normal.dot(p[1]), plane.normal.dot(p[2])});
    plane.flat = plane.high - plane.low <= slack();
    return plane;
  }

  /// How far the box about the convex shape keeps from the triangle along the plane's normal.
  double box_gap_along(const TrianglePlane& plane) const {
    const double middle = plane.normal.dot(mid_);
    return std::max(plane.low - middle, middle - plane.high) -
           (turn_.rotation.transpose() * plane.normal).cwiseAbs().dot(own_half_);
  }

  /// How far the convex shape keeps from the triangle along the plane's normal; a lower bound of the distance.
  double gap_along(const TrianglePlane& plane) const {
    const double gap = box_gap_along(plane);
    if (gap > 0 || view_.kind == ShapeKind::box) return gap;
    const Vec3& n = plane.normal;
    return plane.low > n.dot(mid_) ? plane.low - n.dot(support(n)) : n.dot(support(-n)) - plane.high;
  }
  double plane_gap(const Corners& p) const { return gap_along(plane_of(p)); }

  /// Largest separation of box and triangle along their axes: < 0 says that they overlap, a positive one that they are
  /// apart, 0 that they may: a sliver's normal is not known well enough to tell.
  double box_gap(const Corners& p) const;

  // ---- All of them

  /// Calls visit(t) for the triangles whose boxes come within `margin` of the convex shape, until it returns true.
  template <class Visit>
  void each_near(double margin, Visit&& visit) const {
    query().each_near(margin, visit);
  }

  BoxQuery query() const;
  TriangleScreen screen() const { return {model_, view_, turn_.rotation, shift_, size_}; }

  /// `towards`: normals (unit, towards the convex shape) along which it may lie clear of many triangles.
  bool collide(std::span<const Vec3> towards = {}) const;

  /// The nearest triangle's answer; any that overlaps will do. Of none within `cutoff` (metres) an infinite distance.
  PairAnswer nearest(double cutoff = infinity) const;

  /// At distances that may be rounding's doing the verdict is that of `collide`.
  void decide(PairAnswer& near) const;

  /// Is the convex shape's centre inside a solid mesh?
  bool inside() const;

 private:
  TriangleBound bound_by(const Corners& p, const Vec3& point, Vec3& on_surface) const;
  template <class Visit>
  bool any_thin_part(Visit&& visit) const;
  bool thin_parts_meet() const;
  Vec3 own_centre() const { return view_.hull != nullptr ? view_.hull->inside : Vec3(0, 0, 0); }

  const Posed mesh_;
  const Shape& convex_shape_;
  Pose convex_pose_;
  const MeshModel& model_;
  const ConvexView view_;
  const NarrowPhaseOptions& options_;
  const double size_, radius_;
  Pose turn_;                      // of the convex shape; its origin is the origin
  Vec3 shift_;                     // of the mesh's frame: subtract it from vertices
  Bounds aligned_;                 // of the convex shape along the mesh's axes
  Vec3 mid_, own_mid_, own_half_;  // of its box, along its own axes
};

}  // namespace tandem
