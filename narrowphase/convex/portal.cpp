#include "convex/portal.h"

#include <utility>

#include "convex/projection.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int max_steps = 24;

class Portal {
 public:
  explicit Portal(const MinkowskiDifference& d)
      : d_(d), radius_(core_radius(d.a) + core_radius(d.b)), scale_(d.scale() + off_origin(d.a) + off_origin(d.b)) {}

  PortalResult search();

 private:
  using Verdict = PortalResult::Verdict;

  bool first_direction(const Vec3& centre_b, Vec3& n) const;
  bool open_portal(Vec3& n);
  PortalResult refine_portal(double ball);

  static double off_origin(const ConvexView& v) { return v.hull != nullptr ? v.hull->inside.norm() : 0.0; }

  /// Takes the point farthest along n; false where that proves them apart.
  bool support(const Vec3& n, Vec3& w) const {
    const Vec3 back = -(d_.pose.rotation.transpose() * n);
    w = core_support_point(d_.a, n, kernel_).p -
        (d_.pose.rotation * core_support_point(d_.b, back, kernel_).p + d_.pose.translation);
    if (radius_ > 0) w += (radius_ / n.norm()) * n;
    const double along = n.dot(w), rounding = 16 * epsilon * scale_;
    return !(along < 0 && along * along > rounding * rounding * n.squaredNorm());
  }

  const MinkowskiDifference& d_;
  double radius_, scale_;
  const SupportKernel kernel_ = support_kernel();
  Vec3 v0_, v1_, v2_,
      v3_;  // a point inside A - B, and the portal: supports of A - B about the ray from it to the origin
};

PortalResult Portal::search() {
  // Rotations are orthonormal to 1e-6 only.
  const double ball = (1 - tolerance::askew) * (core_inner_radius(d_.a) + core_inner_radius(d_.b)) + radius_;
  const Vec3 centre_b = d_.pose.rotation * core_centre(d_.b) + d_.pose.translation;
  v0_ = core_centre(d_.a) - centre_b;
  if (ball > tolerance::no_way * scale_ && v0_.squaredNorm() < 0.99 * ball * ball) return {Verdict::overlapping, -v0_};
  if (!(v0_.squaredNorm() > tolerance::no_way2 * scale_ * scale_)) return {Verdict::open, Vec3::UnitX()};
  Vec3 n;
  if (!first_direction(centre_b, n)) return {Verdict::overlapping, -v0_};
  if (!open_portal(n)) return {Verdict::apart, n};
  return refine_portal(ball);
}

/// From B's centre into A, into B and into A again: apart, that comes near the nearest points. False: a point in both.
bool Portal::first_direction(const Vec3& centre_b, Vec3& n) const {
  const double least = tolerance::on_feature * scale_;
  Vec3 a = centre_b;
  if (move_into(d_.a, a, least).inside) return false;
  Vec3 b = d_.pose.rotation.transpose() * (a - d_.pose.translation);
  if (move_into(d_.b, b, least).inside) return false;
  b = d_.pose.rotation * b + d_.pose.translation;
  a = b;
  if (move_into(d_.a, a, least).inside) return false;
  n = b - a;
  if (!(n.squaredNorm() > tolerance::no_way2 * scale_ * scale_)) n = -v0_;
  return true;
}

/// Two corners of the portal, of supports along `n` and across. False: `n` separates.
bool Portal::open_portal(Vec3& n) {
  if (!support(n, v1_)) return false;
  n = v1_.cross(v0_);
  if (!(n.squaredNorm() > tolerance::parallel_lines2 * v0_.squaredNorm() * scale_ * scale_)) n = any_perpendicular(v0_);
  if (!support(n, v2_)) return false;
  n = (v1_ - v0_).cross(v2_ - v0_);
  if (n.dot(v0_) > 0) std::swap(v1_, v2_);
  return true;
}

/// Turns the portal until the ray from v0 to the origin goes through it, then moves it outward.
PortalResult Portal::refine_portal(double ball) {
  int step = 0;
  for (;; ++step) {
    const Vec3 n = (v1_ - v0_).cross(v2_ - v0_);
    if (step == max_steps) return {Verdict::open, -v0_};
    if (!support(n, v3_)) return {Verdict::apart, n};
    if (v1_.cross(v3_).dot(v0_) < 0) {
      v2_ = v3_;
    } else if (v3_.cross(v2_).dot(v0_) < 0) {
      v1_ = v3_;
    } else {
      break;
    }
  }
  // The volumes of the origin with three of the four corners, as products of six times that: off by `volume` at most,
  // which moves the origin within their hull by that over the hull's own volume times its size. The ball about v0
  // leaves as much room about a point as the point is on the way from the portal to v0.
  const double volume = 64 * epsilon * scale_ * scale_ * scale_;
  Vec3 n = Vec3::Zero();
  for (; step < max_steps; ++step) {
    n = (v2_ - v1_).cross(v3_ - v1_);
    const double at_origin = n.dot(v1_);
    if (at_origin > volume && at_origin * ball > 8 * volume * scale_ && v1_.cross(v3_).dot(v0_) > -volume &&
        v3_.cross(v2_).dot(v0_) > -volume && v2_.cross(v1_).dot(v0_) > -volume)
      return {Verdict::overlapping, n};
    Vec3 w;
    if (!(n.squaredNorm() > 0)) break;
    if (!support(n, w)) return {Verdict::apart, n};
    if (!(n.dot(w - v1_) > 16 * epsilon * scale_ * n.norm())) break;
    const Vec3 across = w.cross(v0_);
    if (v1_.dot(across) > 0) {
      (v2_.dot(across) > 0 ? v1_ : v3_) = w;
    } else {
      (v3_.dot(across) > 0 ? v2_ : v1_) = w;
    }
  }
  return {Verdict::open, n};
}

}  // namespace

PortalResult search_portal(const MinkowskiDifference& d) { return Portal(d).search(); }

}  // namespace tandem
