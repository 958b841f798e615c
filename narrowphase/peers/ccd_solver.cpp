// libccd as a solver of two convex shapes.
#include <ccd/ccd.h>

#include "peers/peer_solvers.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// A shape in A's frame, as libccd's callbacks get it by void pointer.
struct Posed {
  const ConvexView* shape;
  RelativePose pose;
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const Posed& o = *static_cast<const Posed*>(object);
  const Vec3 d{direction->v[0], direction->v[1], direction->v[2]};
  const double length = d.norm();
  Vec3 p = o.pose.rotation * core_support(*o.shape, o.pose.rotation.transpose() * d) + o.pose.translation;
  if (length > 0) p += core_radius(*o.shape) / length * d;
  for (int i = 0; i < 3; ++i) out->v[i] = p[i];
}

void centre(const void* object, ccd_vec3_t* out) {
  const Posed& o = *static_cast<const Posed*>(object);
  const Vec3 p = o.pose.rotation * core_centre(*o.shape) + o.pose.translation;
  for (int i = 0; i < 3; ++i) out->v[i] = p[i];
}

ccd_t settings() {
  ccd_t s;
  CCD_INIT(&s);
  s.support1 = s.support2 = support;
  s.center1 = s.center2 = centre;
  s.max_iterations = 200;
  s.epa_tolerance = s.mpr_tolerance = s.dist_tolerance = tolerance::peer_accuracy;
  return s;
}

}  // namespace

std::optional<bool> ccd_collide(const ConvexView& a, const ConvexView& b, const RelativePose& pose, bool portal) {
  const Posed pa{&a, {Mat3::Identity(), Vec3::Zero()}}, pb{&b, pose};
  const ccd_t s = settings();
  return (portal ? ccdMPRIntersect(&pa, &pb, &s) : ccdGJKIntersect(&pa, &pb, &s)) != 0;
}

std::optional<LocalAnswer> ccd_depth(const ConvexView& a, const ConvexView& b, const RelativePose& pose, bool portal) {
  const Posed pa{&a, {Mat3::Identity(), Vec3::Zero()}}, pb{&b, pose};
  const ccd_t s = settings();
  ccd_real_t depth = 0;
  ccd_vec3_t direction{}, position{};
  const int failed = portal ? ccdMPRPenetration(&pa, &pb, &s, &depth, &direction, &position)
                            : ccdGJKPenetration(&pa, &pb, &s, &depth, &direction, &position);
  if (failed != 0) return std::nullopt;
  const Vec3 n{direction.v[0], direction.v[1], direction.v[2]}, at{position.v[0], position.v[1], position.v[2]};
  if (!(std::abs(n.norm() - 1) < tolerance::peer_normal) || !std::isfinite(depth) || !at.allFinite())
    return std::nullopt;
  return LocalAnswer{-depth, at + 0.5 * depth * n, at - 0.5 * depth * n, n, 0};
}

}  // namespace tandem
