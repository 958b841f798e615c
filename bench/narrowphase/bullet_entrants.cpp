// Bullet as a contestant of the narrow-phase bench.
#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <array>

#include "bullet_shape.h"
#include "pair_solver.h"

namespace tandem::bench {
namespace {

// The name gives the precision that this Bullet was built with.

/// The margin of Bullet's shape, which its support function leaves out.
double round_part(const Shape& s) {
  return s.kind() == ShapeKind::sphere || s.kind() == ShapeKind::capsule ? s.radius() : 0;
}

using BulletShapes = std::vector<std::array<std::unique_ptr<btConvexShape>, 2>>;

/// The shapes; empty if one cannot be made.
BulletShapes bullet_shapes(const Question& question) {
  BulletShapes out;
  for (const reference::PosedPair& p : question.pairs) {
    out.push_back({bullet_convex(p.a), bullet_convex(p.b)});
    if (!out.back()[0] || !out.back()[1]) return {};
  }
  return out;
}

struct Deepest final : btDiscreteCollisionDetectorInterface::Result {
  Found found;
  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3& normal_on_b, const btVector3&, btScalar distance) override {
    if (found.measured && distance >= found.signed_distance) return;
    found = {
        .collide = distance <= 0, .measured = true, .signed_distance = distance, .normal = -from_bullet(normal_on_b)};
  }
};

btDiscreteCollisionDetectorInterface::ClosestPointInput input(const reference::PosedPair& p) {
  btDiscreteCollisionDetectorInterface::ClosestPointInput in;
  in.m_transformA = bullet_pose(p.pose_a, p.pose_a.translation);
  in.m_transformB = bullet_pose(p.pose_b, p.pose_a.translation);
  return in;
}

std::unique_ptr<PairSolver> pair_detector(const Question& question) {
  if (question.request == Request::contacts) return nullptr;
  BulletShapes shapes = bullet_shapes(question);
  if (shapes.empty()) return nullptr;
  return each_pair([shapes = std::move(shapes), pairs = question.pairs, simplex = btVoronoiSimplexSolver(),
                    depth = btGjkEpaPenetrationDepthSolver()](std::size_t i) mutable {
    btGjkPairDetector detector(shapes[i][0].get(), shapes[i][1].get(), &simplex, &depth);
    Deepest result;
    detector.getClosestPoints(input(pairs[i]), result, nullptr);
    result.found.failed = !result.found.measured;  // no distance limit was set, so an answer is due
    return result.found;
  });
}

std::unique_ptr<PairSolver> gjk_epa2(const Question& question) {
  if (question.request == Request::contacts) return nullptr;
  BulletShapes shapes = bullet_shapes(question);
  if (shapes.empty()) return nullptr;
  return each_pair([shapes = std::move(shapes), pairs = question.pairs](std::size_t i) {
    const reference::PosedPair& p = pairs[i];
    const btTransform ta = bullet_pose(p.pose_a, p.pose_a.translation),
                      tb = bullet_pose(p.pose_b, p.pose_a.translation);
    btGjkEpaSolver2::sResults result;
    const bool ok = btGjkEpaSolver2::SignedDistance(shapes[i][0].get(), ta, shapes[i][1].get(), tb,
                                                    tb.getOrigin() - ta.getOrigin(), result);
    if (!ok) return Found{.failed = true};
    const double d = result.distance - round_part(p.a) - round_part(p.b);
    // The normal is in A's frame, from B to A or reversed as it happens: not compared.
    return Found{.collide = d <= 0, .measured = true, .signed_distance = d};
  });
}

std::unique_ptr<PairSolver> box_box(const Question& question) {
  if (question.request == Request::distance) return nullptr;
  for (const reference::PosedPair& p : question.pairs)
    if (p.a.kind() != ShapeKind::box || p.b.kind() != ShapeKind::box) return nullptr;
  BulletShapes shapes = bullet_shapes(question);
  return each_pair([shapes = std::move(shapes), pairs = question.pairs](std::size_t i) {
    btBoxBoxDetector detector(static_cast<const btBoxShape*>(shapes[i][0].get()),
                              static_cast<const btBoxShape*>(shapes[i][1].get()));
    Deepest result;
    detector.getClosestPoints(input(pairs[i]), result, nullptr);
    return result.found;
  });
}

}  // namespace

std::vector<Entrant> bullet_entrants() {
  const std::string precision = bullet_is_double ? ", double" : ", float";
  return {{"Bullet GJK+EPA" + precision, pair_detector},
          {"Bullet GjkEpa2" + precision, gjk_epa2},
          {"Bullet box-box" + precision, box_box}};
}

}  // namespace tandem::bench
