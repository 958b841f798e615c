// Two bounded convex shapes by GJK: the order of methods, and when an answer is accepted.
#include "pairs/gjk_pair.h"

#include "convex/epa.h"
#include "convex/exact_polytope.h"
#include "convex/face_depth.h"
#include "convex/feature_normals.h"
#include "convex/gjk.h"
#include "convex/polytope_portal.h"
#include "round/support_descent.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// True if balls inside both overlap.
bool overlap_deeply(const MinkowskiDifference& d) {
  // Rotations are orthonormal only to 1e-6.
  const double reach = (1 - tolerance::askew_in_floats) * (core_inner_radius(d.a) + core_inner_radius(d.b));
  if (!(reach > tolerance::small_ball * d.scale())) return false;
  return (core_centre(d.a) - d.pose.rotation * core_centre(d.b) - d.pose.translation).squaredNorm() < reach * reach;
}

/// True if a plane is the nearest face of the difference to the origin. The plane has height h above the origin; it
/// touches the difference in a disc of radius `margin` about the origin's projection. Planes with a slightly different
/// normal are excluded by that disc, those turned by more than 2 atan(margin / h) by the ball about the centre.
bool is_least(double h, double margin, const Vec3& n, const Vec3& centre, double ball) {
  if (!(margin > h)) return false;
  const double below = -n.dot(centre), aside = (centre + below * n).norm();
  const double m2 = margin * margin, h2 = h * h;
  return below > 0 && below * (m2 - h2) - 2 * margin * h * aside + ball * (m2 + h2) > h * (m2 + h2);
}

/// Answers for two polytopes if the face where the ray through the origin ends is the nearest face; false where that is
/// uncertain.
bool answer_by_face(const MinkowskiDifference& d, const SurfaceFace& face, LocalAnswer& answer) {
  const MinkowskiPoint* const c = face.corner;
  const double scale = d.scale();
  // Edge i leads from corner i to the next.
  const Vec3 edge[3] = {d.edge(c[1], c[0]), d.edge(c[2], c[1]), d.edge(c[0], c[2])};
  const double length[3] = {edge[0].norm(), edge[1].norm(), edge[2].norm()};
  Vec3 n = edge[2].cross(edge[0]);
  if (n.dot(face.normal) < 0) n = -n;
  const double area = n.norm();
  if (!(area > tolerance::wide_face * scale * std::max({length[0], length[1], length[2]}))) return false;
  n /= area;
  const double h = std::max({n.dot(c[0].w), n.dot(c[1].w), n.dot(c[2].w)});
  double inward[3];  // distances from the edges to the origin's projection
  for (int i = 0; i < 3; ++i) inward[i] = n.cross(edge[i]).dot(h * n - c[i].w) / length[i];
  double margin = infinity;
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3, other = (i + 2) % 3;
    // A face from an edge of each shape is a parallelogram, of which the corners are three.
    const auto shares = [&](int p, int q) {
      return c[other].vertex_a == c[p].vertex_a && c[other].vertex_b == c[q].vertex_b;
    };
    const bool diagonal = shares(i, next) || shares(next, i);
    if (!diagonal) {
      margin = std::min(margin, inward[i]);
      continue;
    }
    for (const int side : {next, other}) margin = std::min(margin, area / length[side] - inward[side]);
  }
  if (!(margin > tolerance::near_surface * scale) || (h > 0 && !is_least(h, margin, n, face.centre, face.ball)))
    return false;
  answer.signed_distance = -h;
  answer.normal = n;
  answer.point_a.setZero();
  for (int i = 0; i < 3; ++i) answer.point_a += inward[i] * length[i] / area * c[(i + 2) % 3].a;
  answer.point_b = answer.point_a - h * n;
  answer.gap = 0;
  return true;
}

/// The signed distance of two cores, with its uncertainty.
struct CoreDistance {
  double distance = 0;
  double at_most = 0;  ///< an upper bound, if they overlap
  bool doubtful = false;
};

/// For polytopes near each other, tries the face of the difference above or below the origin; true if that is the
/// answer. Otherwise `towards` is a separating direction, if one was found.
bool answer_on_surface(const MinkowskiDifference& d, double beyond, double reach, Vec3& towards, LocalAnswer& answer) {
  SurfaceFace face;
  surface_kernel()(d, std::min(beyond, reach), face);
  if (face.end == SurfaceFace::End::apart) {
    towards = unit(face.normal);
    const double apart = -towards.dot(face.corner[0].w);
    if (apart > beyond) {
      answer.signed_distance = apart;
      answer.normal = towards;
      return true;
    }
  }
  return face.end == SurfaceFace::End::reached && answer_by_face(d, face, answer);
}

/// For cores that GJK left overlapping or nearly so: the expanding polytope algorithm, to `exact`.
CoreDistance expand_from(const MinkowskiDifference& d, const GjkResult& r, bool deep, double exact,
                         LocalAnswer& answer) {
  const bool polytopes = d.polytopes();
  const double scale = d.scale();
  CoreDistance core;
  EpaResult e = deep ? expand_all_around(d) : expand(d, r.simplex, exact);
  // The planes of sliver faces of the difference have errors of rounding over their width, along all their length: the
  // polytope may tear, and that of a thin overlap may end at another face than the nearest.
  const double shallow = (may_be_thin(d) ? tolerance::thin_overlap : tolerance::near_surface) * scale;
  if (polytopes && (e.upper < shallow || e.upper - e.lower > 16 * epsilon * scale)) expand_exactly(d, e);
  core.distance = -e.upper;
  core.at_most = -e.lower;
  answer.normal = e.normal;
  answer.point_a = e.point_a;
  answer.point_b = e.point_b;
  answer.gap = std::max(0.0, e.upper - e.lower);
  // The bounds of two polytopes this near agree, or are rounding errors.
  const double reached = r.end == GjkResult::End::near               ? r.upper
                         : e.upper < tolerance::near_surface * scale ? r.v.norm()
                                                                     : 0.0;
  core.doubtful = polytopes && (reached > 16 * epsilon * scale || answer.gap > 16 * epsilon * scale ||
                                e.upper < tolerance::near_surface * scale);
  const bool apart = r.end == GjkResult::End::near && r.upper > 0 &&
                     (r.lower > core.distance ? r.lower >= 0 : polytopes && core.distance > 0);
  if (apart) {
    // Separated, possibly by a corner or an edge that no face of the polytope represents.
    if (r.lower > core.distance) answer.normal = r.direction;
    answer.gap = r.upper - std::max(r.lower, core.distance);
    core.distance = r.upper;
    set_points(r.simplex, answer);
  }
  // The difference of polytopes that hardly touch is noise, and so may its direction be.
  const bool touching = polytopes && (r.end == GjkResult::End::near || e.upper < tolerance::near_surface * scale);
  if (touching && separation_along(d, answer.normal) < core.distance - 16 * epsilon * scale) {
    core.doubtful = true;
  } else if (!apart && (e.point_a - e.point_b - e.upper * e.normal).squaredNorm() >
                           (polytopes ? tolerance::on_feature2 : tolerance::on_round2) * scale * scale) {
    answer.signed_distance = core.distance;
    pair_points(d, answer);
    core.distance = answer.signed_distance;
    answer.gap = std::max(0.0, -core.distance - e.lower);
  }
  return core;
}

/// The distance from GJK's result, by its simplex where that is clearly apart from the origin, else by expanding it.
CoreDistance distance_from(const MinkowskiDifference& d, GjkResult& r, bool deep, double precision, double exact,
                           LocalAnswer& answer) {
  const bool polytopes = d.polytopes();
  const double scale = d.scale();
  const bool weighs = r.end == GjkResult::End::inside ? !is_solid(d, r.simplex) : !polytopes;
  if (r.simplex.count > 0 && weighs) set_weights(r.simplex);
  // Without a direction that separates, the nearest point may be that of a sliver in which the origin lies.
  if (polytopes && r.end == GjkResult::End::separated && !(r.lower > 0)) r.end = GjkResult::End::near;
  if (r.end != GjkResult::End::separated) return expand_from(d, r, deep, exact, answer);
  CoreDistance core;
  core.distance = r.upper;
  set_points(r.simplex, answer);
  answer.gap = r.upper - std::max(r.lower, 0.0);
  answer.normal = r.normal(tolerance::place_rounding * scale);
  core.doubtful =
      polytopes && (r.upper - r.lower > precision * r.upper + 4 * epsilon * scale || answer.normal != r.direction);
  return core;
}

/// For two polytopes: true if the facing surfaces give the answer; else GJK is done, started from their direction.
bool answer_or_descend(const MinkowskiDifference& d, double precision, double beyond, const Vec3* start, GjkResult& r,
                       LocalAnswer& answer) {
  const double far = tolerance::far_from_surface * d.scale();
  if (!(beyond < far)) {
    r = descend(d, precision, beyond, -infinity, start, far);
    if (r.lower > far) return false;
  }
  Vec3 towards = Vec3::Zero();
  if (answer_on_surface(d, beyond, far, towards, answer)) return true;
  r = descend(d, precision, beyond, -infinity, towards.isZero(0) ? start : &towards);
  return false;
}

/// True if the origin is in the tetrahedron whatever the rounding of its determinants. For slivers and needles the
/// planes have larger errors than the corners.
bool surely_holds_origin(const Simplex& s) {
  int positive = 0;
  for (int left_out = 0; left_out < 4; ++left_out) {
    const Vec3 &a = s.p[(left_out + 1) % 4].w, &b = s.p[(left_out + 2) % 4].w, &c = s.p[(left_out + 3) % 4].w;
    const Vec3 p = b.cwiseAbs(), q = c.cwiseAbs();
    const double permanent =
        a.cwiseAbs().dot(Vec3(p[1] * q[2] + p[2] * q[1], p[2] * q[0] + p[0] * q[2], p[0] * q[1] + p[1] * q[0]));
    const double volume = a.dot(b.cross(c));
    if (!(std::abs(volume) > tolerance::permanent_rounding * permanent)) return false;
    if ((volume > 0) == (left_out % 2 == 0)) ++positive;  // each rotation of four corners is odd
  }
  return positive == 0 || positive == 4;
}

/// GJK only approaches round surfaces: Newton's method gives the last digits.
void polish(const MinkowskiDifference& d, CoreDistance& core, LocalAnswer& answer) {
  const Support s = minimize(RoundPair(d), answer.normal, -infinity);
  if (!s.optimal) return;
  core.distance = -s.h;
  answer.normal = s.n;
  answer.point_a = s.point[0];
  answer.point_b = -s.point[1];
  answer.gap = core.distance > 0 ? 0 : std::max(0.0, core.at_most - core.distance);
}

}  // namespace

bool gjk_collide(const MinkowskiDifference& d, double tolerance, const Vec3* start, Vec3* direction) {
  const double radius = core_radius(d.a) + core_radius(d.b);
  const double rounding = 16 * epsilon * d.scale();
  if (radius == 0 && d.polytopes()) {
    PortalResult portal;
    portal_kernel()(d, portal);
    if (portal.verdict != PortalResult::Verdict::open) {
      const bool apart = portal.verdict == PortalResult::Verdict::apart;
      if (apart && direction != nullptr) *direction = unit(portal.normal);
      return !apart;
    }
  }
  const GjkResult r =
      descend(d, std::max(tolerance, tolerance::ends_on_polytopes), radius + rounding, radius - rounding, start);
  if (r.lower > radius + rounding) {
    if (direction != nullptr) *direction = r.direction;
    return false;
  }
  // A simplex that contains the origin may only seem to where it has come close before, or is flat.
  const double sure = tolerance::near_surface * d.scale();
  if (r.end == GjkResult::End::inside && r.v.squaredNorm() > sure * sure && is_solid(d, r.simplex) &&
      (!d.polytopes() || surely_holds_origin(r.simplex)))
    return true;
  if (r.end != GjkResult::End::inside && r.upper < radius - rounding) return true;
  return gjk_signed_distance(d, tolerance).signed_distance <= 0;
}

LocalAnswer gjk_signed_distance(const MinkowskiDifference& d, double tolerance, const Vec3* start, double beyond) {
  const double ra = core_radius(d.a), rb = core_radius(d.b);
  const bool polytopes = d.polytopes();
  // Polytopes end after few steps anyway; results cut short by a tolerance were doubtful (3 times as long in the hard
  // class).
  const double precision = polytopes ? tolerance::ends_on_polytopes : std::max(tolerance, tolerance::ends_on_round);
  const double scale = d.scale();
  LocalAnswer answer;
  const bool deep = polytopes && overlap_deeply(d);
  if (deep && depth_by_faces(d, answer)) return answer;
  GjkResult r;
  if (deep) {
    r.end = GjkResult::End::inside;
    r.lower = -infinity;
  } else if (polytopes && ra + rb == 0) {
    if (answer_or_descend(d, precision, beyond, start, r, answer)) return answer;
  } else {
    r = descend(d, precision, beyond + ra + rb, -infinity, start);
  }
  if (r.lower > beyond + ra + rb) return farther_than(beyond, r.lower, ra, rb, r.direction);
  const double exact = polytopes ? 0 : std::max(tolerance * larger(d), tolerance::ends_on_round * scale);
  CoreDistance core = distance_from(d, r, deep, precision, exact, answer);
  if (r.end == GjkResult::End::inside && core.distance > 4 * epsilon * scale) {
    // The polytope is apart from the origin, so the simplex that seemed to contain it is a sliver: from a direction
    // that separates, GJK finds the nearest point.
    r = descend(d, precision, beyond + ra + rb, -infinity, &answer.normal);
    if (r.lower > beyond + ra + rb) return farther_than(beyond, r.lower, ra, rb, r.direction);
    core = distance_from(d, r, deep, precision, exact, answer);
  }
  if (core.doubtful) {
    LocalAnswer settled = answer;
    settled.signed_distance = core.distance;
    if (settle_by_features(d, settled) && settled.signed_distance >= r.lower - 16 * epsilon * scale) {
      answer = settled;
      core.distance = answer.signed_distance;
    }
  }
  if (!polytopes && (core.distance < 0 || tolerance < tolerance::ends_on_round)) polish(d, core, answer);
  answer.signed_distance = core.distance - ra - rb;
  answer.point_a += ra * answer.normal;
  answer.point_b -= rb * answer.normal;
  if (answer.gap <= tolerance::no_gap * (scale + std::abs(core.distance))) answer.gap = 0;
  return answer;
}

}  // namespace tandem
