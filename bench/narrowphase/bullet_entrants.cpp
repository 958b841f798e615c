#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <array>

#include "narrowphase/hull.h"
#include "pair_solver.h"

namespace tandem::bench {
namespace {

// Named with the precision that this Bullet was built with.
constexpr bool is_double = sizeof(btScalar) == sizeof(double);

btScalar scalar(double x) { return static_cast<btScalar>(x); }
btVector3 vector(const Vec3& v) { return {scalar(v[0]), scalar(v[1]), scalar(v[2])}; }
Vec3 vector(const btVector3& v) { return {v[0], v[1], v[2]}; }

/// A's translation is taken from both: coordinates far out cost a float its digits.
btTransform transform(const Pose& pose, const Vec3& origin) {
  const Mat3& r = pose.rotation;
  return btTransform(btMatrix3x3(scalar(r(0, 0)), scalar(r(0, 1)), scalar(r(0, 2)), scalar(r(1, 0)), scalar(r(1, 1)),
                                 scalar(r(1, 2)), scalar(r(2, 0)), scalar(r(2, 1)), scalar(r(2, 2))),
                     vector(Vec3(pose.translation - origin)));
}

/// Null where Bullet has no convex shape of the kind. Without margin where the margin would round edges off.
std::unique_ptr<btConvexShape> make(const Shape& s) {
  std::unique_ptr<btConvexShape> out;
  switch (s.kind()) {
    case ShapeKind::sphere:
      return std::make_unique<btSphereShape>(scalar(s.radius()));
    case ShapeKind::capsule:
      return std::make_unique<btCapsuleShapeZ>(scalar(s.radius()), scalar(s.length()));
    case ShapeKind::box:
      out = std::make_unique<btBoxShape>(vector(s.half_size()));
      break;
    case ShapeKind::cylinder:
      out = std::make_unique<btCylinderShapeZ>(vector(Vec3(s.radius(), s.radius(), 0.5 * s.length())));
      break;
    case ShapeKind::cone:
      out = std::make_unique<btConeShapeZ>(scalar(s.radius()), scalar(s.length()));
      break;
    case ShapeKind::convex: {
      auto hull = std::make_unique<btConvexHullShape>();
      for (const Vec3& v : s.hull().vertices) hull->addPoint(vector(v), false);
      hull->recalcLocalAabb();
      out = std::move(hull);
      break;
    }
    case ShapeKind::triangle: {
      const auto& v = s.hull().vertices;
      if (v.size() != 3) return nullptr;
      out = std::make_unique<btTriangleShape>(vector(v[0]), vector(v[1]), vector(v[2]));
      break;
    }
    default:
      return nullptr;
  }
  out->setMargin(0);
  return out;
}

/// What Bullet keeps as margin and leaves out of the support function.
double round_part(const Shape& s) {
  return s.kind() == ShapeKind::sphere || s.kind() == ShapeKind::capsule ? s.radius() : 0;
}

using Shapes = std::vector<std::array<std::unique_ptr<btConvexShape>, 2>>;

/// Empty where a shape cannot be made.
Shapes build(const Question& question) {
  Shapes out;
  for (const reference::PosedPair& p : question.pairs) {
    out.push_back({make(p.a), make(p.b)});
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
    found = {.collide = distance <= 0, .measured = true, .signed_distance = distance, .normal = -vector(normal_on_b)};
  }
};

btDiscreteCollisionDetectorInterface::ClosestPointInput input(const reference::PosedPair& p) {
  btDiscreteCollisionDetectorInterface::ClosestPointInput in;
  in.m_transformA = transform(p.pose_a, p.pose_a.translation);
  in.m_transformB = transform(p.pose_b, p.pose_a.translation);
  return in;
}

std::unique_ptr<PairSolver> pair_detector(const Question& question) {
  if (question.request == Request::contacts) return nullptr;
  Shapes shapes = build(question);
  if (shapes.empty()) return nullptr;
  return each_pair([shapes = std::move(shapes), pairs = question.pairs, simplex = btVoronoiSimplexSolver(),
                    depth = btGjkEpaPenetrationDepthSolver()](std::size_t i) mutable {
    btGjkPairDetector detector(shapes[i][0].get(), shapes[i][1].get(), &simplex, &depth);
    Deepest result;
    detector.getClosestPoints(input(pairs[i]), result, nullptr);
    result.found.failed = !result.found.measured;  // no distance bound was set: it owes an answer
    return result.found;
  });
}

std::unique_ptr<PairSolver> gjk_epa2(const Question& question) {
  if (question.request == Request::contacts) return nullptr;
  Shapes shapes = build(question);
  if (shapes.empty()) return nullptr;
  return each_pair([shapes = std::move(shapes), pairs = question.pairs](std::size_t i) {
    const reference::PosedPair& p = pairs[i];
    const btTransform ta = transform(p.pose_a, p.pose_a.translation), tb = transform(p.pose_b, p.pose_a.translation);
    btGjkEpaSolver2::sResults result;
    const bool ok = btGjkEpaSolver2::SignedDistance(shapes[i][0].get(), ta, shapes[i][1].get(), tb,
                                                    tb.getOrigin() - ta.getOrigin(), result);
    if (!ok) return Found{.failed = true};
    const double d = result.distance - round_part(p.a) - round_part(p.b);
    // Its normal is in A's frame, from B to A or the other way as it comes: not compared.
    return Found{.collide = d <= 0, .measured = true, .signed_distance = d};
  });
}

std::unique_ptr<PairSolver> box_box(const Question& question) {
  if (question.request == Request::distance) return nullptr;
  for (const reference::PosedPair& p : question.pairs)
    if (p.a.kind() != ShapeKind::box || p.b.kind() != ShapeKind::box) return nullptr;
  Shapes shapes = build(question);
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
  const std::string precision = is_double ? ", double" : ", float";
  return {{"Bullet GJK+EPA" + precision, pair_detector},
          {"Bullet GjkEpa2" + precision, gjk_epa2},
          {"Bullet box-box" + precision, box_box}};
}

}  // namespace tandem::bench
