// libccd as a contestant of the narrow-phase bench.
#include <ccd/ccd.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pair_solver.h"

namespace tandem::bench {
namespace {

/// A shape as libccd's callbacks get it; the pose is set for each query.
struct SupportBody {
  ShapeKind kind = ShapeKind::sphere;
  std::array<double, 3> size{};  ///< half edges, radii, or radius and half length
  std::span<const Vec3> vertices;
  Vec3 middle = Vec3::Zero();
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
};

SupportBody body(const Shape& s) {
  SupportBody out;
  out.kind = s.kind();
  switch (s.kind()) {
    case ShapeKind::sphere:
      out.size = {s.radius(), 0, 0};
      break;
    case ShapeKind::capsule:
    case ShapeKind::cylinder:
    case ShapeKind::cone:
      out.size = {s.radius(), 0.5 * s.length(), 0};
      break;
    case ShapeKind::box:
    case ShapeKind::ellipsoid: {
      const Vec3 h = s.half_size();  // for an ellipsoid, its radii
      out.size = {h.x(), h.y(), h.z()};
      break;
    }
    default:
      out.vertices = s.vertices();
      for (const Vec3& v : out.vertices) out.middle += v / static_cast<double>(out.vertices.size());
  }
  return out;
}

void write(const Vec3& p, ccd_vec3_t* out) {
  for (int i = 0; i < 3; ++i) out->v[i] = p[i];
}

Vec3 local_support(const SupportBody& b, const Vec3& d) {
  const auto& [x, y, z] = b.size;
  switch (b.kind) {
    case ShapeKind::sphere:
      return x / d.norm() * d;
    case ShapeKind::box:
      return {std::copysign(x, d[0]), std::copysign(y, d[1]), std::copysign(z, d[2])};
    case ShapeKind::capsule:
      return Vec3(x / d.norm() * d) + Vec3(0, 0, std::copysign(y, d[2]));
    case ShapeKind::cylinder: {
      const double flat = std::hypot(d[0], d[1]), scale = flat > 0 ? x / flat : 0;
      return {scale * d[0], scale * d[1], std::copysign(y, d[2])};
    }
    case ShapeKind::cone: {
      const double flat = std::hypot(d[0], d[1]), scale = flat > 0 ? x / flat : 0;
      if (2 * y * d[2] > x * flat) return {0, 0, y};
      return {scale * d[0], scale * d[1], -y};
    }
    case ShapeKind::ellipsoid: {
      const Vec3 q(x * d[0], y * d[1], z * d[2]);
      return Vec3(x * q[0], y * q[1], z * q[2]) / q.norm();
    }
    default: {
      const Vec3* best = &b.vertices[0];
      double most = best->dot(d);
      for (const Vec3& v : b.vertices)
        if (const double along = v.dot(d); along > most) most = along, best = &v;
      return *best;
    }
  }
}

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const SupportBody& b = *static_cast<const SupportBody*>(object);
  const Vec3 d(direction->v[0], direction->v[1], direction->v[2]);
  write(b.rotation * local_support(b, b.rotation.transpose() * d) + b.translation, out);
}

void centre(const void* object, ccd_vec3_t* out) {
  const SupportBody& b = *static_cast<const SupportBody*>(object);
  write(b.rotation * b.middle + b.translation, out);
}

enum class Method { gjk, mpr };

ccd_t settings() {
  ccd_t s;
  CCD_INIT(&s);
  s.support1 = s.support2 = support;
  s.center1 = s.center2 = centre;
  s.max_iterations = 200;
  s.epa_tolerance = s.mpr_tolerance = s.dist_tolerance = 1e-10;
  return s;
}

/// Collision verdicts, and for Request::distance the depth of pairs that touch: libccd has no distance of separated
/// pairs.
std::unique_ptr<PairSolver> enter(const Question& question, Method method) {
  if (question.request == Request::contacts) return nullptr;
  std::vector<std::array<SupportBody, 2>> bodies;
  for (const reference::PosedPair& p : question.pairs) {
    if (!p.a.is_bounded() || !p.b.is_bounded()) return nullptr;
    bodies.push_back({body(p.a), body(p.b)});
  }
  const auto pose = [](std::array<SupportBody, 2>& pair, const reference::PosedPair& p) {
    pair[0].rotation = p.pose_a.rotation, pair[0].translation = Vec3::Zero();
    pair[1].rotation = p.pose_b.rotation, pair[1].translation = p.pose_b.translation - p.pose_a.translation;
  };
  const ccd_t s = settings();
  if (question.request == Request::collide)
    return each_pair([bodies = std::move(bodies), pairs = question.pairs, s, method, pose](std::size_t i) mutable {
      pose(bodies[i], pairs[i]);
      const auto& [a, b] = bodies[i];
      return Found{.collide = (method == Method::gjk ? ccdGJKIntersect : ccdMPRIntersect)(&a, &b, &s) != 0};
    });
  return each_pair([bodies = std::move(bodies), pairs = question.pairs, s, method, pose](std::size_t i) mutable {
    pose(bodies[i], pairs[i]);
    const auto& [a, b] = bodies[i];
    ccd_real_t depth = 0;
    ccd_vec3_t direction{}, position{};
    const int status =
        (method == Method::gjk ? ccdGJKPenetration : ccdMPRPenetration)(&a, &b, &s, &depth, &direction, &position);
    if (status != 0) return Found{.failed = status == -2};  // -1: they do not touch
    return Found{.collide = true,
                 .measured = true,
                 .signed_distance = -depth,
                 .normal = Vec3(direction.v[0], direction.v[1], direction.v[2])};
  });
}

}  // namespace

std::vector<Entrant> ccd_entrants() {
  return {{"libccd GJK+EPA", [](const Question& question) { return enter(question, Method::gjk); }},
          {"libccd MPR", [](const Question& question) { return enter(question, Method::mpr); }}};
}

}  // namespace tandem::bench
