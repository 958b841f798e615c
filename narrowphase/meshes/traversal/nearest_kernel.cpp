// Lower bounds on distances of boxes and triangles (vector kernel).
#include "meshes/traversal/nearest_kernel.h"

#include <algorithm>
#include <cmath>

#include "meshes/traversal/hierarchy.h"
#include "shapes/unit_vector.h"

#include "tolerances.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "meshes/traversal/nearest_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if !HWY_HAVE_SCALABLE

using N = hn::CappedTag<double, mesh_lanes>;
using Lane = hn::Vec<N>;

HWY_INLINE Lane all(double x) { return hn::Set(N(), x); }
HWY_INLINE Lane widen(const float* from) { return hn::PromoteTo(N(), hn::Load(hn::Rebind<float, N>(), from)); }
// Never fused: the same bits with any instruction set.
HWY_INLINE Lane add(Lane x, Lane y, Lane to) { return hn::Add(hn::Mul(x, y), to); }
HWY_INLINE Lane dot(const Lane* u, const Lane* v) { return add(u[0], v[0], add(u[1], v[1], hn::Mul(u[2], v[2]))); }
HWY_INLINE Lane dot(const Vec3& u, const Lane* v) {
  return add(all(u[0]), v[0], add(all(u[1]), v[1], hn::Mul(all(u[2]), v[2])));
}
HWY_INLINE Lane dot_abs(const Lane* u, const Lane* v) {
  return add(hn::Abs(u[0]), v[0], add(hn::Abs(u[1]), v[1], hn::Mul(hn::Abs(u[2]), v[2])));
}
HWY_INLINE Lane positive(Lane x) { return hn::Max(x, hn::Zero(N())); }
HWY_INLINE Lane length(const Lane* u) { return hn::Sqrt(dot(u, u)); }

// Some of a node's children.
struct Slabs {
  Lane mid[3], half[3], thin[3], thin_mid, thin_half;

  HWY_INLINE Slabs(const MeshModel& mesh, const MeshNode& node, std::size_t l) {
    const ChildBoxes& boxes = mesh.boxes_of(node);
    for (int i = 0; i < 3; ++i) mid[i] = widen(boxes.mid[i] + l), half[i] = widen(boxes.half[i] + l);
    const ChildSlabs& slabs = mesh.slabs[node.block];
    for (int i = 0; i < 3; ++i) thin[i] = widen(slabs.normal[i] + l);
    thin_mid = widen(slabs.mid + l), thin_half = widen(slabs.half + l);
  }
  // The minimum of u . x over each, times |u|: by the box alone, or by the planes for the component of u along the thin
  // direction.
  HWY_INLINE Lane least(const Lane* u) const {
    const Lane cosine = dot(u, thin), back = hn::Neg(cosine);
    const Lane w[3] = {add(back, thin[0], u[0]), add(back, thin[1], u[1]), add(back, thin[2], u[2])};
    const Lane by_planes = hn::Sub(hn::Mul(cosine, thin_mid), hn::Mul(hn::Abs(cosine), thin_half));
    return hn::Max(hn::Sub(dot(u, mid), dot_abs(u, half)), hn::Add(by_planes, hn::Sub(dot(w, mid), dot_abs(w, half))));
  }
};

struct Triangles {
  Lane mid[3], half[3], corner[3][3];

  HWY_INLINE Triangles(const MeshModel& mesh, const MeshNode& node, std::size_t l) {
    const TriangleBlock& block = mesh.blocks[node.block];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) corner[k][i] = widen(block.corner[k][i] + l);
    for (int i = 0; i < 3; ++i) {
      const Lane low = hn::Min(hn::Min(corner[0][i], corner[1][i]), corner[2][i]);
      const Lane high = hn::Max(hn::Max(corner[0][i], corner[1][i]), corner[2][i]);
      mid[i] = hn::Mul(hn::Add(low, high), all(0.5));
      half[i] = hn::Sub(high, mid[i]);
    }
  }
  HWY_INLINE Lane least(const Lane* u) const {
    return hn::Min(hn::Min(dot(u, corner[0]), dot(u, corner[1])), dot(u, corner[2]));
  }
};

// The direction from the nearest point of the box to a point, for each lane.
HWY_INLINE void direction_to(const NearBox& box, const Lane* to, Lane* direction) {
  const Lane d[3] = {hn::Sub(to[0], all(box.mid[0])), hn::Sub(to[1], all(box.mid[1])), hn::Sub(to[2], all(box.mid[2]))};
  for (int i = 0; i < 3; ++i) direction[i] = hn::Zero(N());
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = box.axes.col(k);
    const Lane along = dot(axis, d), beyond = positive(hn::Sub(hn::Abs(along), all(box.half[k])));
    const Lane out = hn::CopySign(beyond, along);
    for (int i = 0; i < 3; ++i) direction[i] = add(out, all(axis[i]), direction[i]);
  }
}
// By the three edges and the face (Ericson, Real-Time Collision Detection, 5.1.5).
HWY_INLINE void direction_to(const NearTriangle& t, const Lane* to, Lane* direction) {
  Lane nearest = all(1e300);
  auto over = hn::Eq(nearest, nearest);
  for (std::size_t k = 3; k-- > 0;) {
    const Vec3 &from = t.corner[k], &edge = t.edge[k];
    const Lane d[3] = {hn::Sub(to[0], all(from[0])), hn::Sub(to[1], all(from[1])), hn::Sub(to[2], all(from[2]))};
    const Lane back = hn::Neg(hn::Min(positive(hn::Mul(dot(edge, d), all(t.per_square[k]))), all(1)));
    const Lane w[3] = {add(back, all(edge[0]), d[0]), add(back, all(edge[1]), d[1]), add(back, all(edge[2]), d[2])};
    const Lane square = dot(w, w);
    const auto nearer = hn::Lt(square, nearest);
    nearest = hn::Min(nearest, square);
    for (int i = 0; i < 3; ++i) direction[i] = k == 2 ? w[i] : hn::IfThenElse(nearer, w[i], direction[i]);
    over = hn::And(over, hn::Lt(dot(t.outward[k], d), hn::Zero(N())));
    if (k > 0) continue;
    const Lane height = dot(t.normal, d);
    for (int i = 0; i < 3; ++i) direction[i] = hn::IfThenElse(over, hn::Mul(height, all(t.normal[i])), direction[i]);
  }
}

// The maximum of u . x over the box, times |u|.
HWY_INLINE Lane most_of_box(const NearBox& box, const Lane* u) {
  Lane top = dot(box.mid, u);
  for (int k = 0; k < 3; ++k) top = add(hn::Abs(dot(Vec3(box.axes.col(k)), u)), all(box.half[k]), top);
  return top;
}
HWY_INLINE Lane most(const NearBox& box, const Lane* u) {
  const Lane by = dot(box.thin, u), back = hn::Neg(by);
  const Lane w[3] = {add(back, all(box.thin[0]), u[0]), add(back, all(box.thin[1]), u[1]),
                     add(back, all(box.thin[2]), u[2])};
  const Lane by_planes = add(hn::Abs(by), all(box.thin_half), hn::Mul(by, all(box.thin_mid)));
  return hn::Min(most_of_box(box, u), hn::Add(by_planes, most_of_box(box, w)));
}
HWY_INLINE Lane most(const NearTriangle& t, const Lane* u) {
  return hn::Max(hn::Max(dot(t.corner[0], u), dot(t.corner[1], u)), dot(t.corner[2], u));
}

template <class Shape, class Children>
HWY_INLINE Lane bound(const Shape& shape, const NearVolume& volume, const NearPlane& plane, double enough,
                      const Children& c) {
  const Lane tiny = all(tolerance::never_zero_length);
  const auto along = [&](const Lane* direction) HWY_ATTR {
    return hn::Div(hn::Sub(c.least(direction), most(shape, direction)), hn::Max(length(direction), tiny));
  };
  // The gaps of boxes along the frame's axes, and the vector from the volume's centre to the nearest point of the
  // child's box.
  Lane gap[3], to_box[3];
  for (int i = 0; i < 3; ++i) {
    const Lane d = hn::Sub(c.mid[i], all(volume.aligned_mid[i])), beyond = hn::Sub(hn::Abs(d), c.half[i]);
    gap[i] = positive(hn::Sub(beyond, all(volume.aligned_half[i])));
    to_box[i] = hn::CopySign(positive(beyond), d);
  }
  const Lane u[3] = {all(plane.normal[0]), all(plane.normal[1]), all(plane.normal[2])};
  const Lane quick = hn::Max(length(gap), hn::Sub(c.least(u), all(plane.top)));
  if (hn::AllTrue(N(), hn::Gt(quick, all(enough)))) return quick;
  Lane direction[3];
  direction_to(shape, c.mid, direction);
  return hn::Max(quick, hn::Max(along(direction), along(to_box)));
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void bound_distances(const NearVolume& volume, const NearPlane& plane, const MeshModel& mesh, const MeshNode& node,
                     double enough, double* least) {
  const auto each = [&](const auto& shape) HWY_ATTR {
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(N()))
      hn::StoreU(node.bottom() ? bound(shape, volume, plane, enough, Triangles(mesh, node, l))
                               : bound(shape, volume, plane, enough, Slabs(mesh, node, l)),
                 N(), least + l);
  };
  if (const NearBox* box = std::get_if<NearBox>(&volume.shape))
    each(*box);
  else
    each(std::get<NearTriangle>(volume.shape));
}

#else

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void bound_distances(const NearVolume&, const NearPlane&, const MeshModel&, const MeshNode&, double, double* least) {
  std::fill_n(least, mesh_lanes, -1.0);
}

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(bound_distances);

NearVolume::NearVolume(const NearBox& box)
    : shape(box), aligned_mid(box.mid), aligned_half(box.axes.cwiseAbs() * box.half) {}

NearVolume::NearVolume(const std::array<Vec3, 3>& p) : shape(std::in_place_type<NearTriangle>) {
  const Vec3 lo = p[0].cwiseMin(p[1]).cwiseMin(p[2]), hi = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
  aligned_mid = (lo + hi) / 2;
  aligned_half = (hi - lo) / 2;
  NearTriangle& t = std::get<NearTriangle>(shape);
  t.corner = p;
  t.normal = unit(area_vector(p));
  for (std::size_t k = 0; k < 3; ++k) {
    t.edge[k] = p[(k + 1) % 3] - p[k];
    const double square = t.edge[k].squaredNorm();
    t.per_square[k] = square > tolerance::shortest_squared ? 1 / square : 0;
    t.outward[k] = t.edge[k].cross(t.normal);
  }
}

double NearVolume::reach(const Vec3& n) const {
  if (const NearTriangle* t = std::get_if<NearTriangle>(&shape))
    return std::max({n.dot(t->corner[0]), n.dot(t->corner[1]), n.dot(t->corner[2])});
  const NearBox& box = std::get<NearBox>(shape);
  const auto of_box = [&](const Vec3& u) {
    return u.dot(box.mid) + (box.axes.transpose() * u).cwiseAbs().dot(box.half);
  };
  const double by = box.thin.dot(n);
  return std::min(of_box(n), by * box.thin_mid + std::abs(by) * box.thin_half + of_box(n - by * box.thin));
}

NearVolume MeshView::volume(std::uint32_t ref) const {
  const double per_unit = 1 / unit;  // a power of two
  if (is_leaf(mesh, ref)) {
    std::array<Vec3, 3> p = mesh.corners(leaf_triangle(mesh, ref));
    for (Vec3& corner : p) corner = turn * ((corner - mesh.centre) * per_unit) + shift;
    return NearVolume(p);
  }
  const BoxOf own(mesh, ref);
  NearBox box{turn * ((own.mid - mesh.centre) * per_unit) + shift, own.half * per_unit, turn};
  if (const std::uint32_t k = lane_of(ref); k != whole) {
    const ChildSlabs& slabs = mesh.slabs[mesh.nodes[node_of(ref)].block];
    const double scale = mesh.unit * per_unit;
    box.thin = turn * Vec3(slabs.normal[0][k], slabs.normal[1][k], slabs.normal[2][k]);
    box.thin_mid = scale * slabs.mid[k] + box.thin.dot(shift);
    box.thin_half = scale * slabs.half[k];
  }
  return NearVolume(box);
}

void bound_distances(const NearVolume& volume, const NearPlane& plane, const MeshModel& mesh, const MeshNode& node,
                     double enough, std::array<double, mesh_lanes>& least) {
  HWY_DYNAMIC_DISPATCH(bound_distances)(volume, plane, mesh, node, enough, least.data());
}
}  // namespace tandem
#endif
