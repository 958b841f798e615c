// The steps of Minkowski portal refinement, for all shapes and for the instruction set that the including file is
// compiled for.
#if defined(TANDEM_NARROWPHASE_PORTAL_STEPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TANDEM_NARROWPHASE_PORTAL_STEPS_INL_H
#undef TANDEM_NARROWPHASE_PORTAL_STEPS_INL_H
#else
#define TANDEM_NARROWPHASE_PORTAL_STEPS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

/// A triangle of points of A - B, and its normal in the orientation v1, v2, v3. `Corner::at` is the point.
template <class Corner>
struct Portal {
  Corner v1, v2, v3;
  decltype(Corner::at) n{};
};

enum class PortalEnd : std::uint8_t { open, apart, overlapping, surface };  ///< apart: v1 is the farthest along n
enum class PortalAim : std::uint8_t { verdict, surface };

/// Moves a portal outward along the ray from a point inside A - B, the centre, through the origin. `Difference` has
/// `centre()`; `scale()`; `ball()`, the radius of a ball about the centre in A - B; and `farthest(n, w)`, the farthest
/// point along n, which is false if that shows the shapes separated.
template <class Corner, class Difference>
class PortalSteps {
  using Vector = decltype(Corner::at);

 public:
  explicit PortalSteps(const Difference& difference) : d_(difference), centre_(difference.centre()) {}

  /// Runs until the portal has passed the origin (where only a verdict is wanted), lies on the surface, or its normal
  /// separates the shapes.
  template <PortalAim aim>
  HWY_INLINE PortalEnd search(Portal<Corner>& portal) const {
    constexpr int max_steps = 24;
    auto& [v1, v2, v3, n] = portal;
    // Iterates until the ray goes through the triangle: it usually does at once.
    int step = 0;
    for (;; ++step) {
      if (step == max_steps) return PortalEnd::open;
      if (volume(v1.at, v3.at) < 0) {
        v2 = v3;
      } else if (volume(v3.at, v2.at) < 0) {
        v1 = v3;
      } else if (volume(v2.at, v1.at) < 0) {
        std::swap(v1, v2);
      } else {
        break;
      }
      n = (v1.at - centre_).cross(v2.at - centre_);
      if (!d_.farthest(n, v3)) {
        v1 = v3;
        return PortalEnd::apart;
      }
    }
    const double rounding = 16 * epsilon * d_.scale();
    for (; step < max_steps; ++step) {
      n = (v2.at - v1.at).cross(v3.at - v1.at);
      if (aim == PortalAim::verdict && holds_origin(portal, n.dot(v1.at))) return PortalEnd::overlapping;
      Corner w;
      if (!d_.farthest(n, w)) {
        v1 = w;
        return PortalEnd::apart;
      }
      const double gained = n.dot(w.at - v1.at);
      if (!(gained > 0 && gained * gained > rounding * rounding * n.dot(n))) return PortalEnd::surface;
      const Vector across = w.at.cross(centre_);
      if (v1.at.dot(across) > 0) {
        (v2.at.dot(across) > 0 ? v1 : v3) = w;
      } else {
        (v3.at.dot(across) > 0 ? v2 : v1) = w;
      }
    }
    return PortalEnd::open;
  }

 private:
  /// True if the origin lies between the triangle and the centre for certain; `at_origin`: a sixth of it is the volume
  /// of the origin and the triangle.
  HWY_INLINE bool holds_origin(const Portal<Corner>& portal, double at_origin) const {
    const Vector &v1 = portal.v1.at, &v2 = portal.v2.at, &v3 = portal.v3.at;
    // The relative error of volumes, times the squared length of the longest vector involved.
    const double off = 128 * epsilon * d_.scale(), longest2 = std::max({v1.dot(v1), v2.dot(v2), v3.dot(v3)});
    if (!(at_origin > off * longest2)) return false;
    const double side_off = off * std::max(longest2, centre_.dot(centre_));
    const double least = std::min({volume(v1, v3), volume(v3, v2), volume(v2, v1)});
    // The origin may lie beyond a side plane by less than the clearance of the ball about the centre: the error of the
    // volumes against the ball's cross-section between the portal and the centre.
    return least > side_off || (least > -side_off && at_origin * d_.ball() > 8 * side_off * d_.scale());
  }
  /// Six times the volume of the tetrahedron of p, q, the centre and the origin.
  HWY_INLINE double volume(const Vector& p, const Vector& q) const { return p.cross(q).dot(centre_); }

  const Difference& d_;
  const Vector centre_;
};

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
