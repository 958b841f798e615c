// FCL's queries of a pair, answered by the narrow phase, with the interface of fcl/narrowphase/collision.h and
// distance.h.
#include "tandem/fcl/pair_queries.h"

#include <algorithm>
#include <array>
#include <vector>

#include "fcl_answers.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/triangles_at.h"

namespace tandem::fcl {
namespace {

using detail::GeometryPair;

/// With default options: constructed once, which takes as long as the distance of two spheres.
const NarrowPhase& plain_narrow_phase() {
  static const NarrowPhase narrow_phase;
  return narrow_phase;
}

/// A contact that only names the two geometries. FCL leaves the rest unset.
template <class S>
::fcl::Contact<S> touch(const GeometryPair<S>& q, int b1 = ::fcl::Contact<S>::NONE, int b2 = ::fcl::Contact<S>::NONE) {
  return {q.o1, q.o2, b1, b2, ::fcl::Vector3<S>::Zero(), ::fcl::Vector3<S>::Zero(), S(0)};
}

/// The triangles of meshes at a contact or answer, in FCL's terms: NONE for other geometries.
template <class S, class Place>
std::array<int, 2> triangles(const GeometryPair<S>& q, const Place& place) {
  const auto at = triangles_at(*q.a, to_pose(q.tf1), *q.b, to_pose(q.tf2), place);
  const auto name = [](const Shape& shape, std::uint32_t triangle) {
    return shape.kind() == ShapeKind::mesh ? static_cast<int>(triangle) : ::fcl::Contact<S>::NONE;
  };
  return {name(*q.a, at[0]), name(*q.b, at[1])};
}

template <class S>
::fcl::Contact<S> to_contact(const GeometryPair<S>& q, const Contact& c) {
  const auto [b1, b2] = triangles(q, c);
  return {q.o1, q.o2, b1, b2, c.point.cast<S>(), c.normal.cast<S>(), static_cast<S>(c.depth)};
}

template <class S>
void add_contacts(const GeometryPair<S>& q, std::vector<Contact>& contacts, std::size_t room,
                  ::fcl::CollisionResult<S>& result) {
  if (contacts.size() > room)
    std::stable_sort(contacts.begin(), contacts.end(),
                     [](const Contact& a, const Contact& b) { return a.depth > b.depth; });
  contacts.resize(std::min(contacts.size(), room));
  for (const Contact& contact : contacts) result.addContact(to_contact(q, contact));
}

template <class S>
std::size_t answer_collide(const GeometryPair<S>& q, const ::fcl::CollisionRequest<S>& request,
                           ::fcl::CollisionResult<S>& result) {
  if (request.num_max_contacts == 0) return 0;
  if (q.a == nullptr || q.b == nullptr || request.enable_cost) return fcl_collide(q, request, result);
  if (request.isSatisfied(result) || !q.o1->isOccupied() || !q.o2->isOccupied()) return result.numContacts();

  const std::size_t room = request.num_max_contacts - result.numContacts();
  const Pose pose_a = to_pose(q.tf1), pose_b = to_pose(q.tf2);
  const NarrowPhase& narrow_phase = plain_narrow_phase();
  if (request.enable_contact) {
    std::vector<Contact> contacts;
    if (narrow_phase.solve(*q.a, pose_a, *q.b, pose_b, Request::contacts, &contacts).collide)
      add_contacts(q, contacts, room, result);
  } else if (room > 1 && q.a->kind() == ShapeKind::mesh && q.b->kind() == ShapeKind::mesh) {
    const auto triangles = narrow_phase.intersecting_triangles(*q.a, pose_a, *q.b, pose_b);
    for (std::size_t i = 0; i < std::min(room, triangles.size()); ++i)
      result.addContact(touch(q, static_cast<int>(triangles[i][0]), static_cast<int>(triangles[i][1])));
  } else if (narrow_phase.solve(*q.a, pose_a, *q.b, pose_b, Request::collide).collide) {
    result.addContact(touch(q));
  }
  return result.numContacts();
}

template <class S>
S answer_distance(const GeometryPair<S>& q, const ::fcl::DistanceRequest<S>& request,
                  ::fcl::DistanceResult<S>& result) {
  if (q.a == nullptr || q.b == nullptr) return fcl_distance(q, request, result);
  if (request.isSatisfied(result)) return result.min_distance;

  const Pose pose_a = to_pose(q.tf1), pose_b = to_pose(q.tf2);
  const NarrowPhase& narrow_phase = plain_narrow_phase();
  constexpr int none = ::fcl::DistanceResult<S>::NONE;
  // The depth of meshes takes far longer than the fact that they overlap.
  const bool only_overlap = !request.enable_signed_distance && !(q.a->is_convex() && q.b->is_convex()) &&
                            narrow_phase.solve(*q.a, pose_a, *q.b, pose_b, Request::collide).collide;
  if (only_overlap) {
    result.update(-1, q.o1, q.o2, none, none);
    return result.min_distance;
  }
  const PairAnswer answer = narrow_phase.solve(*q.a, pose_a, *q.b, pose_b, Request::distance);
  const bool is_told = answer.signed_distance >= 0 || request.enable_signed_distance;
  const S least = is_told ? static_cast<S>(answer.signed_distance) : S(-1);
  if (request.enable_nearest_points) {
    const auto [b1, b2] = triangles(q, answer);
    result.update(least, q.o1, q.o2, b1, b2, answer.point_a.cast<S>(), answer.point_b.cast<S>());
  } else {
    result.update(least, q.o1, q.o2, none, none);
  }
  return result.min_distance;
}

}  // namespace

std::size_t detail::collide_pair(const GeometryPair<float>& pair, const ::fcl::CollisionRequest<float>& request,
                                 ::fcl::CollisionResult<float>& result) {
  return answer_collide(pair, request, result);
}
std::size_t detail::collide_pair(const GeometryPair<double>& pair, const ::fcl::CollisionRequest<double>& request,
                                 ::fcl::CollisionResult<double>& result) {
  return answer_collide(pair, request, result);
}
float detail::distance_pair(const GeometryPair<float>& pair, const ::fcl::DistanceRequest<float>& request,
                            ::fcl::DistanceResult<float>& result) {
  return answer_distance(pair, request, result);
}
double detail::distance_pair(const GeometryPair<double>& pair, const ::fcl::DistanceRequest<double>& request,
                             ::fcl::DistanceResult<double>& result) {
  return answer_distance(pair, request, result);
}

}  // namespace tandem::fcl
