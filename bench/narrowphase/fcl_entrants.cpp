// FCL as a contestant of the narrow-phase bench.
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <array>

#include "fcl_shape.h"
#include "pair_solver.h"

namespace tandem::bench {
namespace {

using FclShapes = std::vector<std::array<std::shared_ptr<fcl::CollisionGeometryd>, 2>>;

FclShapes fcl_shapes(const Question& question) {
  FclShapes out;
  for (const reference::PosedPair& p : question.pairs) out.push_back({fcl_shape(p.a), fcl_shape(p.b)});
  return out;
}

std::unique_ptr<PairSolver> collide(const Question& question) {
  const bool contacts = question.request == Request::contacts;
  fcl::CollisionRequestd request(contacts ? 4 : 1, contacts);
  request.gjk_tolerance = 1e-10;
  return each_pair([shapes = fcl_shapes(question), pairs = question.pairs, request, contacts](std::size_t i) {
    fcl::CollisionResultd result;
    const reference::PosedPair& p = pairs[i];
    fcl::collide(shapes[i][0].get(), fcl_pose(p.pose_a, p.pose_a.translation), shapes[i][1].get(),
                 fcl_pose(p.pose_b, p.pose_a.translation), request, result);
    Found out{.collide = result.isCollision()};
    if (contacts)
      for (std::size_t k = 0; k < result.numContacts(); ++k) {
        const fcl::Contactd& c = result.getContact(k);
        if (!out.measured || -c.penetration_depth < out.signed_distance)
          out.measured = true, out.signed_distance = -c.penetration_depth, out.normal = c.normal;
      }
    return out;
  });
}

/// Distances. Unsigned, FCL has closed forms for some pairs, but no depth of pairs that touch.
std::unique_ptr<PairSolver> distance(const Question& question, bool is_signed) {
  // FCL has no support function of a half-space.
  for (const reference::PosedPair& p : question.pairs)
    if (!p.a.is_bounded() || !p.b.is_bounded()) return nullptr;
  fcl::DistanceRequestd request(true, is_signed);
  request.distance_tolerance = 1e-10;
  return each_pair([shapes = fcl_shapes(question), pairs = question.pairs, request, is_signed](std::size_t i) {
    fcl::DistanceResultd result;
    const reference::PosedPair& p = pairs[i];
    fcl::distance(shapes[i][0].get(), fcl_pose(p.pose_a, p.pose_a.translation), shapes[i][1].get(),
                  fcl_pose(p.pose_b, p.pose_a.translation), request, result);
    const double d = result.min_distance;
    Found out{.collide = d <= 0, .measured = true, .signed_distance = d};
    if (d <= 0 && !is_signed) return Found{.collide = true};
    // FCL gives no normal here: its users take the direction between the witness points.
    const Vec3 between = result.nearest_points[1] - result.nearest_points[0];
    if (const double length = between.norm(); length > 0) out.normal = (d > 0 ? 1 : -1) / length * between;
    return out;
  });
}

}  // namespace

std::vector<Entrant> fcl_entrants() {
  return {{"FCL",
           [](const Question& question) {
             return question.request == Request::distance ? distance(question, true) : collide(question);
           }},
          {"FCL unsigned", [](const Question& question) {
             return question.request == Request::distance ? distance(question, false) : nullptr;
           }}};
}

}  // namespace tandem::bench
