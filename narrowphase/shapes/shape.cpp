// Shapes: checks, bounding boxes, mass, memory.
#include "tandem/narrowphase/shape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

#include "shapes/hull.h"
#include "shapes/hull_builder.h"
#include "shapes/kind_rows.h"
#include "shapes/mass_properties.h"
#include "shapes/mesh_builder.h"
#include "shapes/mesh_hierarchy.h"
#include "shapes/shape_insides.h"
#include "shapes/support_kernel.h"
#include "shapes/voxel_reach.h"
#include "shapes/without_hull.h"
#include "shapes/written.h"
#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/shape_memory.h"
#include "tolerances.h"

namespace tandem {
namespace {

using detail::BuiltParts;
using detail::SharedParts;

// The coordinate of the open sides of half-spaces and planes.
constexpr double open_side = 1e300;

[[noreturn]] void refuse(std::string_view field, double value, const std::string& allowed) {
  throw std::invalid_argument(std::string(field) + " is " + written(value) + "; it must be " + allowed);
}

// The permitted lengths, for messages.
std::string allowed_lengths() {
  return "from " + written(tolerance::shortest_length) + " to " + written(tolerance::longest_length);
}

void require_positive(std::string_view field, double value) {
  if (!(value >= tolerance::shortest_length && value <= tolerance::longest_length))
    refuse(field, value, "> 0, " + allowed_lengths());
}

void require_not_negative(std::string_view field, double value) {
  if (!(value == 0 || (value >= tolerance::shortest_length && value <= tolerance::longest_length)))
    refuse(field, value, "0, or " + allowed_lengths());
}

void require_number(std::string_view field, double value) {
  if (!(std::abs(value) <= tolerance::longest_length)) refuse(field, value, allowed_coordinate());
}

void require_vertices(std::string_view what, std::span<const Vec3> vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(vertices[i][k]) <= tolerance::longest_length))
        require_number(std::string(what) + ": vertices[" + std::to_string(i) + "][" + std::to_string(k) + "]",
                       vertices[i][k]);
}

/// Points may coincide, but not have an extent too small to compute with. `extent`: along the axes; the square of its
/// length, `size`, may underflow.
void require_extent(std::string_view what, const Vec3& extent, double size) {
  const double largest = extent.maxCoeff();
  if (largest > 0 && size < tolerance::shortest_length)
    refuse(std::string(what) + ": extent of the vertices", largest,
           "0, or at least " + written(tolerance::shortest_length));
}

/// The hull of only those points that are its vertices, so that a hull made of a hull's vertices is the same one, with
/// its faces in the same order.
Hull hull_of_its_vertices(std::span<const Vec3> points) {
  Hull hull = build_hull(points);
  for (std::size_t before = points.size(); hull.vertices.size() < before;) {
    before = hull.vertices.size();
    hull = build_hull(std::vector<Vec3>(hull.vertices));
  }
  return hull;
}

/// The unit normal and the offset of the plane normal . x = offset.
std::array<double, 4> unit_plane(const std::string& what, const Vec3& normal, double offset) {
  for (int k = 0; k < 3; ++k) require_number(what + ": normal[" + std::to_string(k) + "]", normal[k]);
  require_number(what + ": offset", offset);
  const double length = normal.stableNorm();
  if (!(length >= tolerance::shortest_normal))
    refuse(what + ": length of normal", length, "at least " + written(tolerance::shortest_normal));
  // A normal that is unit to rounding is kept, so that written numbers are read back as the same bits.
  if (std::abs(length - 1) <= 4 * epsilon) return {normal.x(), normal.y(), normal.z(), offset};
  const Vec3 n = (normal / length).normalized();
  require_number(what + ": offset / length of normal", offset / length);
  return {n.x(), n.y(), n.z(), offset / length};
}

/// Along an axis that is the normal: closes the box where the half-space n . x <= offset of a body at `t` ends.
void close_side(Bounds& open, const Vec3& n, double offset, const Vec3& t) {
  for (int k = 0; k < 3; ++k)
    if (n[k] != 0 && n[(k + 1) % 3] == 0 && n[(k + 2) % 3] == 0)
      (n[k] > 0 ? open.hi : open.lo)[k] = t[k] + (n[k] > 0 ? offset : -offset);
}

Bounds around(const Vec3& centre, const Vec3& half) { return {centre - half, centre + half}; }

// The box by the hierarchy, where the hull is not needed.
template <class Farthest>
Bounds bounds_by_hierarchy(const Pose& pose, Farthest&& farthest) {
  Vec3 lo, hi;
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = pose.rotation.row(k).transpose();
    lo[k] = -farthest(Vec3(-axis));
    hi[k] = farthest(axis);
  }
  return {lo + pose.translation, hi + pose.translation};
}

Bounds posed_bounds(const Hull& hull, const Pose& pose) {
  // Rotated first and translated last, so that a far translation is rounded only once.
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
  const auto add = [&](const Vec3& vertex) {
    const Vec3 v = pose.rotation * vertex;
    lo = lo.cwiseMin(v);
    hi = hi.cwiseMax(v);
  };
  constexpr std::size_t few = 64;  // all are examined in the time of six searches
  if (hull.vertices.size() <= few) {
    for (const Vec3& v : hull.vertices) add(v);
  } else {
    const SupportKernel farthest = support_kernel();
    for (int k = 0; k < 3; ++k)
      for (const double sense : {1.0, -1.0}) {
        const Vec3 d = sense * pose.rotation.row(k).transpose();
        add(hull.vertices[farthest(hull.support, hull.vertices.data(), d.data())]);
      }
  }
  return {lo + pose.translation, hi + pose.translation};
}

}  // namespace

std::string_view name(ShapeKind kind) { return kind_row(kind).name; }

Shape::Shape(const Sphere& s) : kind_(ShapeKind::sphere), param_{s.radius} {
  require_not_negative("sphere: radius", s.radius);
  size_ = 2 * std::sqrt(3.0) * s.radius;
}

Shape::Shape(const Box& s) : kind_(ShapeKind::box), param_{s.size.x() / 2, s.size.y() / 2, s.size.z() / 2} {
  for (int k = 0; k < 3; ++k) require_positive("box: size[" + std::to_string(k) + "]", s.size[k]);
  size_ = s.size.norm();
  parts_ = std::make_shared<SharedParts>();
}

Shape::Shape(const Capsule& s) : kind_(ShapeKind::capsule), param_{s.radius, s.length} {
  require_positive("capsule: radius", s.radius);
  require_not_negative("capsule: length", s.length);
  size_ = Vec3(2 * s.radius, 2 * s.radius, s.length + 2 * s.radius).norm();
  parts_ = std::make_shared<SharedParts>();
}

Shape::Shape(const Cylinder& s) : kind_(ShapeKind::cylinder), param_{s.radius, s.length} {
  require_positive("cylinder: radius", s.radius);
  require_positive("cylinder: length", s.length);
  size_ = Vec3(2 * s.radius, 2 * s.radius, s.length).norm();
  parts_ = std::make_shared<SharedParts>();
}

Shape::Shape(const Cone& s) : kind_(ShapeKind::cone), param_{s.radius, s.length} {
  require_positive("cone: radius", s.radius);
  require_positive("cone: length", s.length);
  size_ = Vec3(2 * s.radius, 2 * s.radius, s.length).norm();
  parts_ = std::make_shared<SharedParts>();
}

Shape::Shape(const Ellipsoid& s) : kind_(ShapeKind::ellipsoid), param_{s.radii.x(), s.radii.y(), s.radii.z()} {
  for (int k = 0; k < 3; ++k) require_positive("ellipsoid: radii[" + std::to_string(k) + "]", s.radii[k]);
  size_ = 2 * s.radii.norm();
  parts_ = std::make_shared<SharedParts>();
}

Shape::Shape(const HalfSpace& s) : kind_(ShapeKind::halfspace), param_(unit_plane("halfspace", s.normal, s.offset)) {
  parts_ = std::make_shared<SharedParts>();
}

Shape::Shape(const Plane& s) : kind_(ShapeKind::plane), param_(unit_plane("plane", s.normal, s.offset)) {
  parts_ = std::make_shared<SharedParts>();
}

Shape::Shape(const Convex& s) : kind_(ShapeKind::convex) {
  if (s.vertices.empty()) throw std::invalid_argument("convex: vertices is empty; at least one point is needed");
  require_vertices("convex", s.vertices);
  const Bounds b = bounds_of(s.vertices);
  size_ = (b.hi - b.lo).norm();
  require_extent("convex", b.hi - b.lo, size_);
  auto hull = std::make_shared<const Hull>(hull_of_its_vertices(s.vertices));
  parts_ = std::make_shared<BuiltParts>(std::move(hull), nullptr);
}

Shape::Shape(const Triangle& s) : kind_(ShapeKind::triangle) {
  require_vertices("triangle", s.vertices);
  // Queries that return triangles treat it as a mesh of one.
  auto mesh =
      std::make_shared<const MeshModel>(build_mesh({{s.vertices.begin(), s.vertices.end()}, {{0, 1, 2}}, false}, {}));
  size_ = 2 * mesh->half.norm();
  require_extent("triangle", 2 * mesh->half, size_);
  parts_ = std::make_shared<BuiltParts>(std::make_shared<const Hull>(build_hull(s.vertices)), std::move(mesh));
}

Shape::Shape(Mesh s) : Shape(std::move(s), BuildOptions()) {}

Shape::Shape(Mesh s, const PartRunner& parts) : Shape(std::move(s), BuildOptions{parts}) {}

Shape::Shape(Mesh s, const BuildOptions& options) : kind_(ShapeKind::mesh) {
  require_vertices("mesh", s.vertices);
  *this = detail::ShapeInsides::shape(std::make_shared<MeshModel>(build_mesh(std::move(s), options)));
}

Shape detail::ShapeInsides::shape(std::shared_ptr<const MeshModel> model) {
  Shape s = Sphere{0};
  s.kind_ = ShapeKind::mesh;
  s.size_ = 2 * model->half.norm();
  require_extent("mesh", 2 * model->half, s.size_);
  s.parts_ = std::make_shared<BuiltParts>(nullptr, std::move(model));
  return s;
}

Shape::Shape(const Voxels& s) : kind_(ShapeKind::voxels) {
  auto model = std::make_shared<const VoxelModel>(build_voxels(s));
  param_ = {s.origin.x(), s.origin.y(), s.origin.z(), s.cell_size};
  size_ = 2 * model->box(model->root()).second.norm();
  parts_ = std::make_shared<BuiltParts>(nullptr, nullptr, std::move(model));
}

Shape Shape::rounded(double radius) const {
  require_not_negative("rounding", radius);
  if (kind_ == ShapeKind::sphere) return Sphere{this->radius() + radius};
  if (kind_ == ShapeKind::capsule) return Capsule{this->radius() + radius, length()};
  if (kind_ == ShapeKind::halfspace) return HalfSpace{normal(), offset() + radius};
  Shape s = *this;
  s.rounding_ += radius;
  require_not_negative("rounding", s.rounding_);
  // Separate shared data, whose address is identity(): a rounded shape differs from its core.
  if (detail::ShapeInsides::is_built(*this)) {
    const BuiltParts& parts = detail::ShapeInsides::parts(*this);
    s.parts_ = std::make_shared<BuiltParts>(parts.hull, parts.mesh, parts.voxels);
  } else {
    s.parts_ = std::make_shared<SharedParts>();
  }
  if (!is_bounded()) return s;
  const Bounds box = s.bounds(Pose{});
  s.size_ = (box.hi - box.lo).norm();
  return s;
}

MassProperties Shape::mass() const {
  if (kind_ == ShapeKind::sphere) return mass_of(*this);
  return parts_->mass.get([this] { return mass_of(*this); });
}

// For a sphere the bits of its radius with the sign bit set, which no address of user space has.
std::uint64_t Shape::identity() const {
  if (kind_ == ShapeKind::sphere) return std::bit_cast<std::uint64_t>(radius()) | std::uint64_t{1} << 63;
  return reinterpret_cast<std::uintptr_t>(parts_.get());
}

ShapeMemory Shape::memory_by_part() const {
  ShapeMemory memory = has_mesh(*this) ? mesh_of(*this).memory() : ShapeMemory{};
  if (has_hull(*this)) memory.hull += hull_of(*this).memory();
  if (kind_ == ShapeKind::voxels) {
    const VoxelModel& voxels = voxels_of(*this);
    memory.surface += voxels.cells.capacity() * sizeof(VoxelCell);
    memory.hierarchy += voxels.nodes.capacity() * sizeof(VoxelModel::Node);
    memory.other += sizeof(VoxelModel) + voxels.boxes.capacity() * sizeof(Shape);
    for (const Shape& box : voxels.boxes) memory.other += box.memory();
  }
  memory.other += detail::ShapeInsides::memory_of_parts(*this);
  return memory;
}

// In addition, std::make_shared stores two counters and a table's address.
std::size_t detail::ShapeInsides::memory_of_parts(const Shape& shape) {
  if (shape.parts_ == nullptr) return 0;
  return (is_built(shape) ? sizeof(BuiltParts) : sizeof(SharedParts)) + 2 * sizeof(void*) +
         (shape.parts_->mass.is_made() ? sizeof(MassProperties) : 0);
}

std::size_t memory_of(std::span<const Shape> shapes) {
  std::vector<std::pair<const void*, std::size_t>> held;  // address and bytes of each shared object
  for (const Shape& shape : shapes) {
    if (const void* parts = detail::ShapeInsides::address_of_parts(shape))
      held.emplace_back(parts, detail::ShapeInsides::memory_of_parts(shape));
    if (has_hull(shape)) held.emplace_back(&hull_of(shape), hull_of(shape).memory());
    if (has_mesh(shape)) held.emplace_back(&mesh_of(shape), mesh_of(shape).memory().total());
    if (shape.kind() == ShapeKind::voxels)
      held.emplace_back(&voxels_of(shape), shape.memory() - detail::ShapeInsides::memory_of_parts(shape));
  }
  const auto address = [](const auto& part) { return reinterpret_cast<std::uintptr_t>(part.first); };
  std::sort(held.begin(), held.end(), [&](const auto& x, const auto& y) { return address(x) < address(y); });
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < held.size(); ++i)
    if (i == 0 || held[i].first != held[i - 1].first) bytes += held[i].second;
  return bytes;
}

std::span<const Vec3> Shape::vertices() const {
  if (has_mesh(*this)) return mesh_of(*this).vertices;
  if (has_hull(*this)) return hull_of(*this).vertices;
  return {};
}

std::span<const std::array<std::uint32_t, 3>> Shape::triangles() const {
  if (!has_mesh(*this)) return {};
  return mesh_of(*this).triangles;
}

std::span<const VoxelCell> Shape::cells() const {
  if (kind_ != ShapeKind::voxels) return {};
  return voxels_of(*this).cells;
}

bool Shape::is_solid() const {
  if (kind_ == ShapeKind::mesh) return mesh_of(*this).solid;
  return kind_ != ShapeKind::triangle && kind_ != ShapeKind::plane;
}

Bounds Shape::bounds(const Pose& pose, const WorkLimit* limit) const {
  const Bounds core = core_bounds(pose, limit);
  return {core.lo - Vec3::Constant(rounding_), core.hi + Vec3::Constant(rounding_)};
}

Bounds Shape::core_bounds(const Pose& pose, const WorkLimit* limit) const {
  const Mat3& r = pose.rotation;
  const Vec3& t = pose.translation;
  switch (kind_) {
    case ShapeKind::sphere:
      return around(t, Vec3::Constant(radius()));
    case ShapeKind::box:
      return around(t, r.cwiseAbs() * half_size());
    case ShapeKind::capsule:
      return around(t, r.col(2).cwiseAbs() * (length() / 2) + Vec3::Constant(radius()));
    case ShapeKind::cylinder:
      return around(t, r.col(2).cwiseAbs() * (length() / 2) + r.leftCols<2>().rowwise().norm() * radius());
    case ShapeKind::cone: {
      const Vec3 apex = r.col(2) * (length() / 2), disc = r.leftCols<2>().rowwise().norm() * radius();
      return {t + apex.cwiseMin(-apex - disc), t + apex.cwiseMax(-apex + disc)};
    }
    case ShapeKind::ellipsoid:
      return around(t, (r * radii().asDiagonal()).rowwise().norm());
    case ShapeKind::halfspace:
    case ShapeKind::plane: {
      Bounds b{Vec3::Constant(-open_side), Vec3::Constant(open_side)};
      const Vec3 n = r * normal();
      close_side(b, n, offset(), t);
      if (kind_ == ShapeKind::plane) close_side(b, -n, -offset(), t);
      return b;
    }
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return posed_bounds(hull_of(*this), pose);
    case ShapeKind::mesh: {
      const MeshModel& mesh = mesh_of(*this);
      if (!does_without_hull(mesh)) return posed_bounds(mesh.hull(limit), pose);
      return bounds_by_hierarchy(pose, [&](const Vec3& axis) { return farthest_along(mesh, axis); });
    }
    case ShapeKind::voxels:
      return bounds_by_hierarchy(pose,
                                 [&](const Vec3& axis) { return farthest_along(voxels_of(*this), axis, limit); });
  }
  return {t, t};
}

}  // namespace tandem
