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
};

PortalResult Portal::search() {
  using Verdict = PortalResult::Verdict;
  // Rotations are orthonormal to 1e-6 only.
  const double ball = (1 - tolerance::askew) * (core_inner_radius(d_.a) + core_inner_radius(d_.b)) + radius_;
  const Vec3 centre_b = d_.pose.rotation * core_centre(d_.b) + d_.pose.translation, v0 = core_centre(d_.a) - centre_b;
  PortalResult r;
  const auto says = [&r](Verdict verdict, const Vec3& n) {
    r.verdict = verdict, r.normal = n;
    return r;
  };
  if (ball > tolerance::no_way * scale_ && v0.squaredNorm() < 0.99 * ball * ball) return says(Verdict::overlapping, -v0);
  if (!(v0.squaredNorm() > tolerance::no_way2 * scale_ * scale_)) return says(Verdict::open, Vec3::UnitX());
  // From B's centre into A, into B and into A again: apart, that comes near the shortest way.
  const double least = tolerance::on_feature * scale_;
  Vec3 a = centre_b;
  if (move_into(d_.a, a, least).inside) return says(Verdict::overlapping, -v0);
  Vec3 b = d_.pose.rotation.transpose() * (a - d_.pose.translation);
  if (move_into(d_.b, b, least).inside) return says(Verdict::overlapping, -v0);
  b = d_.pose.rotation * b + d_.pose.translation;
  a = b;
  if (move_into(d_.a, a, least).inside) return says(Verdict::overlapping, -v0);
  Vec3 n = b - a;
  if (!(n.squaredNorm() > tolerance::no_way2 * scale_ * scale_)) n = -v0;
  Vec3 v1, v2, v3;
  if (!support(n, v1)) return says(Verdict::apart, n);
  n = v1.cross(v0);
  if (!(n.squaredNorm() > tolerance::parallel_lines2 * v0.squaredNorm() * scale_ * scale_)) n = any_perpendicular(v0);
  if (!support(n, v2)) return says(Verdict::apart, n);
  n = (v1 - v0).cross(v2 - v0);
  if (n.dot(v0) > 0) std::swap(v1, v2), n = -n;
  // Until the ray goes through the triangle.
  int step = 0;
  for (;; ++step) {
    if (step == max_steps) return says(Verdict::open, -v0);
    if (!support(n, v3)) return says(Verdict::apart, n);
    if (v1.cross(v3).dot(v0) < 0) {
      v2 = v3;
    } else if (v3.cross(v2).dot(v0) < 0) {
      v1 = v3;
    } else {
      break;
    }
    n = (v1 - v0).cross(v2 - v0);
  }
  // The volumes of the origin with three of the four corners, as products of six times that: off by `volume` at most,
  // which moves the origin within their hull by that over the hull's own volume times its size. The ball about v0
  // leaves as much room about a point as the point is on the way from the portal to v0.
  const double volume = 64 * epsilon * scale_ * scale_ * scale_;
  for (; step < max_steps; ++step) {
    n = (v2 - v1).cross(v3 - v1);
    const double at_origin = n.dot(v1);
    if (at_origin > volume && at_origin * ball > 8 * volume * scale_ && v1.cross(v3).dot(v0) > -volume &&
        v3.cross(v2).dot(v0) > -volume && v2.cross(v1).dot(v0) > -volume)
      return says(Verdict::overlapping, n);
    Vec3 w;
    if (!(n.squaredNorm() > 0)) break;
    if (!support(n, w)) return says(Verdict::apart, n);
    if (!(n.dot(w - v1) > 16 * epsilon * scale_ * n.norm())) break;
    const Vec3 across = w.cross(v0);
    if (v1.dot(across) > 0) {
      (v2.dot(across) > 0 ? v1 : v3) = w;
    } else {
      (v3.dot(across) > 0 ? v2 : v1) = w;
    }
  }
  return says(Verdict::open, n);
}

}  // namespace

PortalResult search_portal(const MinkowskiDifference& d) { return Portal(d).search(); }

}  // namespace tandem
