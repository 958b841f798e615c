// Minkowski portal refinement for any convex shapes.
#include "convex/portal.h"

#include <utility>

#include "convex/portal_steps-inl.h"
#include "convex/projection.h"
#include "tolerances.h"

namespace tandem {
namespace {

// Compiled for the least instruction set, since the cost of a step is that of the supports.
using HWY_NAMESPACE::PortalAim;
using HWY_NAMESPACE::PortalEnd;

struct PortalCorner {
  Vec3 at;
};
using RoundFace = HWY_NAMESPACE::Portal<PortalCorner>;

class RoundPortal {
 public:
  explicit RoundPortal(const MinkowskiDifference& d)
      : d_(d),
        radius_(core_radius(d.a) + core_radius(d.b)),
        scale_(rounding_scale(d)),
        // Rotations are orthonormal only to 1e-6.
        ball_((1 - tolerance::askew) * (core_inner_radius(d.a) + core_inner_radius(d.b)) + radius_),
        centre_b_(d.pose.rotation * core_centre(d.b) + d.pose.translation),
        centre_(core_centre(d.a) - centre_b_) {}

  PortalResult search() const;

  double ball() const { return ball_; }
  double scale() const { return scale_; }
  const Vec3& centre() const { return centre_; }
  bool farthest(const Vec3& n, PortalCorner& w) const;

 private:
  using Verdict = PortalResult::Verdict;

  bool first_direction(Vec3& n) const;
  bool begin(RoundFace& portal) const;

  const MinkowskiDifference& d_;
  const double radius_, scale_, ball_;
  const Vec3 centre_b_, centre_;
  const SupportKernel kernel_ = support_kernel();
};

/// False if that shows the shapes separated.
bool RoundPortal::farthest(const Vec3& n, PortalCorner& w) const {
  const double length2 = n.squaredNorm();
  if (!(length2 > 0)) {  // a triangle without area has no normal: any point of the surface will do
    farthest(-centre_, w);
    return true;
  }
  const Vec3 back = -(d_.pose.rotation.transpose() * n);
  w.at = core_support_point(d_.a, n, kernel_).p -
         (d_.pose.rotation * core_support_point(d_.b, back, kernel_).p + d_.pose.translation);
  if (radius_ > 0) w.at += (radius_ / n.norm()) * n;
  const double along = n.dot(w.at), rounding = 16 * epsilon * scale_;
  return !(along < 0 && along * along > rounding * rounding * length2);
}

PortalResult RoundPortal::search() const {
  if (ball_ > tolerance::no_centre_line * scale_ && centre_.squaredNorm() < tolerance::balls_overlap2 * ball_ * ball_)
    return {Verdict::overlapping, -centre_};
  if (!(centre_.squaredNorm() > tolerance::no_centre_line2 * scale_ * scale_)) return {Verdict::open, Vec3::UnitX()};
  RoundFace portal;
  if (!first_direction(portal.n)) return {Verdict::overlapping, -centre_};
  if (!begin(portal)) return {Verdict::apart, portal.n};
  switch (HWY_NAMESPACE::PortalSteps<PortalCorner, RoundPortal>(*this).search<PortalAim::verdict>(portal)) {
    case PortalEnd::apart:
      return {Verdict::apart, portal.n};
    case PortalEnd::overlapping:
      return {Verdict::overlapping, portal.n};
    case PortalEnd::open:
    case PortalEnd::surface:
      break;
  }
  return {Verdict::open, portal.n};
}

/// The first direction: from B's centre into A, into B and into A again, which, for separated shapes, approaches the
/// nearest points. False: a point in both was found.
bool RoundPortal::first_direction(Vec3& n) const {
  const double least = tolerance::on_feature * scale_;
  Vec3 a = centre_b_;
  if (move_into(d_.a, a, least).inside) return false;
  Vec3 b = d_.pose.rotation.transpose() * (a - d_.pose.translation);
  if (move_into(d_.b, b, least).inside) return false;
  b = d_.pose.rotation * b + d_.pose.translation;
  a = b;
  if (move_into(d_.a, a, least).inside) return false;
  n = b - a;
  if (!(n.squaredNorm() > tolerance::no_centre_line2 * scale_ * scale_)) n = -centre_;
  return true;
}

/// The initial corners of the portal: supports along `n` and across it. False: `n` separates.
bool RoundPortal::begin(RoundFace& portal) const {
  auto& [v1, v2, v3, n] = portal;
  if (!farthest(n, v1)) return false;
  n = v1.at.cross(centre_);
  if (!(n.squaredNorm() > tolerance::parallel_lines2 * centre_.squaredNorm() * scale_ * scale_))
    n = any_perpendicular(centre_);
  if (!farthest(n, v2)) return false;
  n = (v1.at - centre_).cross(v2.at - centre_);
  if (n.dot(centre_) > 0) {
    std::swap(v1, v2);
    n = -n;
  }
  return farthest(n, v3);
}

}  // namespace

PortalResult search_portal(const MinkowskiDifference& d) { return RoundPortal(d).search(); }

}  // namespace tandem
