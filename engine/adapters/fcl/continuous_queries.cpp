// FCL's continuous queries of a pair, answered by times of impact, with the interface of
// fcl/narrowphase/continuous_collision.h.
#include "tandem/fcl/continuous_queries.h"

#include <optional>

#include "fcl_answers.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::fcl {
namespace {

template <class S>
::fcl::Transform3<S> to_transform(const Pose& pose) {
  ::fcl::Transform3<S> transform = ::fcl::Transform3<S>::Identity();
  transform.linear() = pose.rotation.cast<S>();
  transform.translation() = pose.translation.cast<S>();
  return transform;
}

template <class S>
Motion to_motion(const ::fcl::Transform3<S>& start, const ::fcl::Transform3<S>& end, ::fcl::CCDMotionType type) {
  Motion motion{to_pose(start), to_pose(end)};
  if (type == ::fcl::CCDM_TRANS) motion.to.rotation = motion.from.rotation;
  if (type == ::fcl::CCDM_LINEAR) motion.straight_of = Vec3::Zero();
  return motion;
}

template <class S>
S answer_continuous(const detail::MovingPair<S>& q, const ::fcl::ContinuousCollisionRequest<S>& request,
                    ::fcl::ContinuousCollisionResult<S>& result) {
  const detail::GeometryPair<S>& pair = q.start;
  if (pair.a == nullptr || pair.b == nullptr || request.ccd_motion_type == ::fcl::CCDM_SPLINE)
    return fcl_continuous(q, request, result);
  const Motion a = to_motion(pair.tf1, q.end1, request.ccd_motion_type);
  const Motion b = to_motion(pair.tf2, q.end2, request.ccd_motion_type);
  std::optional<FirstTouch> touch;
  if (pair.o1->isOccupied() && pair.o2->isOccupied()) touch = NarrowPhase().time_of_impact(*pair.a, a, *pair.b, b);
  const double t = touch ? touch->t : 1;
  result.is_collide = touch.has_value();
  result.time_of_contact = static_cast<S>(t);
  result.contact_tf1 = to_transform<S>(pose_at(a, t));
  result.contact_tf2 = to_transform<S>(pose_at(b, t));
  return result.time_of_contact;
}

}  // namespace

float detail::continuous_pair(const MovingPair<float>& pair, const ::fcl::ContinuousCollisionRequest<float>& request,
                              ::fcl::ContinuousCollisionResult<float>& result) {
  return answer_continuous(pair, request, result);
}
double detail::continuous_pair(const MovingPair<double>& pair, const ::fcl::ContinuousCollisionRequest<double>& request,
                               ::fcl::ContinuousCollisionResult<double>& result) {
  return answer_continuous(pair, request, result);
}

}  // namespace tandem::fcl
