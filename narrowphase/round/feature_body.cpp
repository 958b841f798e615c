// Bodies whose nearest features are searched: projections and features at a point.
#include "round/feature_body.h"

#include "round/hull_projection.h"

namespace tandem {
namespace {

Feature hull_feature(const FeatureBody& body, const NearestOnBody& nearest) {
  const ConvexView& core = body.core;
  Feature f;
  f.surface = nearest.surface;
  if (f.surface == Surface::flat) {
    f.face = nearest.face;
    f.axis = body.frame_direction(core.hull->faces[nearest.face].normal);
    f.point = body.frame_point(nearest.q);
  } else if (f.surface == Surface::straight) {
    const Vec3 v = core.vertices[nearest.vertex], along = core.vertices[nearest.other] - v;
    f.high = along.norm();
    f.axis = body.frame_direction(unit(along));
    f.point = body.frame_point(v);
  } else {
    f.point = body.frame_point(nearest.q);
  }
  return f;
}

/// The axis perpendicular to the box's face on which q lies, or along its edge.
int box_axis(const ConvexView& box, const Vec3& q, double least, bool on_face) {
  int k = 0;
  while (k < 2 && (std::abs(q[k]) < box.param[static_cast<std::size_t>(k)] - least) == on_face) ++k;
  return k;
}

/// Sets the line of a box's edge, a capsule's segment, or a cylinder's lateral surface, which is its axis and a radius.
void set_line(const FeatureBody& body, const Vec3& q, double least, Feature& f) {
  const ConvexView& core = body.core;
  if (core.kind == ShapeKind::box) {
    const int k = box_axis(core, q, least, false);
    f.axis = body.axis(k);
    f.high = core.param[static_cast<std::size_t>(k)];
    f.point = body.frame_point(q) - q[k] * f.axis;
  } else {
    f.axis = body.axis(2);
    f.high = 0.5 * core.param[1];
    f.point = body.centre;
    if (core.kind == ShapeKind::cylinder) f.radius = core.param[0];
  }
  f.low = -f.high;
}

/// From a face to the point of the other body farthest back along its normal.
bool face_to_body(const FeatureBody& body, const Feature& flat, const FeatureBody& other, double rounding,
                  NearestPoints& w) {
  w.n = flat.axis;
  w.b = other.support(-w.n);
  w.a = w.b - (w.b - flat.point).dot(w.n) * w.n;
  const Vec3 q = body.local_point(w.a);
  if (body.core.kind == ShapeKind::convex) {
    const Vec3 end = end_on_face(*body.core.hull, flat.face, body.local_point(flat.point), q, rounding);
    w.a = body.frame_point(end);
    return end == q;
  }
  Vec3 moved = q;
  move_into(body.core, moved, 0);
  w.a = body.frame_point(moved);
  return (moved - q).squaredNorm() <= rounding * rounding;
}

}  // namespace

NearestOnBody project(const FeatureBody& body, Vec3& p, double least, const NearestOnBody* last) {
  NearestOnBody nearest;
  nearest.q = body.local_point(p);
  if (body.core.kind == ShapeKind::convex) {
    const Hull& hull = *body.core.hull;
    const std::uint32_t from = last != nullptr
                                   ? last->vertex
                                   : core_support_point(body.core, nearest.q - hull.inside, support_kernel()).vertex;
    const NearestOnHull found = nearest_on_hull(hull, nearest.q, from);
    nearest = {found.q, found.surface, false, found.vertex, found.other, found.face};
  } else {
    const Projection moved = move_into(body.core, nearest.q, least);
    nearest.surface = moved.surface, nearest.inside = moved.inside;
  }
  p = body.frame_point(nearest.q);
  return nearest;
}

Feature feature(const FeatureBody& body, const NearestOnBody& nearest, double least) {
  const ConvexView& core = body.core;
  if (core.kind == ShapeKind::convex) return hull_feature(body, nearest);
  const Vec3& q = nearest.q;
  const double half = 0.5 * core.param[1];
  Feature f;
  f.surface = nearest.surface;
  switch (f.surface) {
    case Surface::flat: {
      const int k = core.kind == ShapeKind::box ? box_axis(core, q, least, true) : 2;
      f.axis = std::copysign(1.0, q[k]) * body.axis(k);
      f.point = body.frame_point(q);
      break;
    }
    case Surface::straight:
      set_line(body, q, least, f);
      break;
    case Surface::side: {
      const double radius = core.param[0], length = core.param[1], slant = std::sqrt(radius * radius + length * length);
      f.axis = body.axis(2);
      f.point = body.centre + half * f.axis;
      f.sine = radius / slant, f.cosine = length / slant;
      f.high = slant;
      break;
    }
    case Surface::circle: {
      f.u = body.axis(0), f.v = body.axis(1);
      f.radius = core.param[0];
      f.point = body.centre + std::copysign(half, q[2]) * body.axis(2);
      const double rho = std::sqrt(q[0] * q[0] + q[1] * q[1]);
      f.c = q[0] / rho, f.s = q[1] / rho;
      break;
    }
    default:
      f.point = body.frame_point(q);
  }
  return f;
}

bool nearest_points(const FeatureBody& a, const Feature& fa, const FeatureBody& b, const Feature& fb, double rounding,
                    NearestPoints& w) {
  if (fa.surface == Surface::flat) return face_to_body(a, fa, b, rounding, w);
  if (fb.surface == Surface::flat) return w.exchanged([&] { return face_to_body(b, fb, a, rounding, w); });
  return nearest_points(fa, fb, rounding, w);
}

}  // namespace tandem
