// The support of a polytope and a round body along the polytope's face normals.
#include "round/face_reach.h"

#include "shapes/triangle_height.h"

namespace tandem {
namespace {

/// The normal of a flat polygon's side, in the polygon's plane, outward.
Vec3 side_normal(const Hull& polygon, const Hull::Edge& side) {
  const Vec3 along = polygon.vertices[side.v[1]] - polygon.vertices[side.v[0]];
  return along.cross(polygon.faces[side.face[0]].normal).stableNormalized();
}

}  // namespace

void FaceReach::measure(const RoundBody& polytope, const RoundBody& circle) {
  count_ = 0;
  axes_ = circle.axes();
  const Mat3 turn = circle.axes().transpose() * polytope.axes();
  const Vec3 centre = polytope.axes().transpose() * (polytope.centre() + circle.centre());
  const auto set = [&](const Vec3& normal, double offset) {
    const Vec3 m = turn * normal, s = circle.circle_support(m);
    for (int k = 0; k < 3; ++k) m_[k][count_] = m[k], s_[k][count_] = s[k];
    base_[count_] = offset + centre.dot(normal);
    h_[count_] = base_[count_] + m.dot(s);
    ++count_;
  };
  if (polytope.kind() == ShapeKind::box) {
    for (int k = 0; k < 3; ++k)
      for (const double sign : {1.0, -1.0})
        set(sign * Vec3::Unit(k), polytope.view().param[static_cast<std::size_t>(k)]);
    return;
  }
  if (polytope.kind() == ShapeKind::triangle) {
    const auto& v = polytope.view().vertices;
    const Vec3 n = normal_of(v[1] - v[0], v[2] - v[1], v[0] - v[2]).normalized();
    set(n, n.dot(v[0]));
    set(-n, -n.dot(v[0]));
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 out = (v[(i + 1) % 3] - v[i]).cross(n).normalized();
      set(out, out.dot(v[i]));
    }
    return;
  }
  const Hull& hull = polytope.hull();
  for (const Hull::Face& f : hull.faces) {
    if (count_ == most) return;
    set(f.normal, f.offset);
  }
  if (hull.dimension == 3) return;
  for (const Hull::Edge& e : hull.edges) {
    if (count_ == most) return;
    const Vec3 out = side_normal(hull, e);
    set(out, out.dot(hull.vertices[e.v[0]]));
  }
}

FaceReach::Least FaceReach::least() const {
  Least r{0, h_[0]};
  for (std::size_t i = 1; i < count_; ++i)
    if (h_[i] < r.h) r = {i, h_[i]};
  return r;
}

Vec3 face_normal(const RoundBody& body, const FaceReach& reach, std::size_t face) {
  if (body.kind() == ShapeKind::triangle) return reach.normal(face);
  if (body.kind() != ShapeKind::box) {
    const Hull& hull = body.hull();
    const std::size_t faces = hull.faces.size();
    return body.axes() * (face < faces ? hull.faces[face].normal : side_normal(hull, hull.edges[face - faces]));
  }
  const Vec3 n = body.axes().col(static_cast<int>(face / 2));
  return face % 2 == 0 ? n : Vec3(-n);
}

}  // namespace tandem
