// Shapes: their kinds and parameters, and Shape, a checked shape that queries take.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/pose.h"

namespace tandem {

struct BuildOptions;  // build_options.h
struct WorkLimit;     // work_limit.h

/// Shapes as given by users, each in its own frame, SI units. Lengths are 0 (where permitted) or 1e-30 to 1e30.
struct Sphere { double radius = 0; };                      ///< radius >= 0; 0 is a point
struct Box { Vec3 size = Vec3::Zero(); };                  ///< full edge lengths > 0, centred
struct Capsule { double radius = 0; double length = 0; };  ///< radius > 0; core segment of length >= 0 along z, centred
struct Cylinder { double radius = 0; double length = 0; }; ///< radius > 0, full height > 0 along z, centred
struct Cone { double radius = 0; double length = 0; };     ///< base at z = -length/2, apex at z = +length/2
struct Ellipsoid { Vec3 radii = Vec3::Zero(); };           ///< radii > 0
struct HalfSpace { Vec3 normal = Vec3::UnitZ(); double offset = 0; };  ///< normal . x <= offset; any length but 0
struct Plane { Vec3 normal = Vec3::UnitZ(); double offset = 0; };      ///< normal . x = offset, two-sided: no inside
struct Convex { std::vector<Vec3> vertices; };             ///< the hull of one or more points; may be flat
struct Triangle { std::array<Vec3, 3> vertices; };         ///< may have no area
struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  /// True: the inside counts too; each edge must then have as many triangles in one direction as in the other.
  bool solid = false;
};

/// A cube of a grid, 2^level of the smallest cells wide: from `corner` to corner + 2^level along each axis, in cells.
struct VoxelCell {
  std::array<std::int32_t, 3> corner{};  ///< multiples of 2^level; all of the cube from -2^20 to 2^20
  std::uint8_t level = 0;                ///< <= 20; 0: a smallest cell
  bool operator==(const VoxelCell&) const = default;
};
/// The union of closed cubes of a grid, solid: the occupied cells of an octree or an occupancy grid.
struct Voxels {
  std::vector<VoxelCell> cells;   ///< 1 to 2^26, in any order; duplicates, and cells within others, count once
  double cell_size = 0;           ///< of a smallest cell, >= 1e-9 of the origin's coordinates; all: <= 5e29 wide
  Vec3 origin = Vec3::Zero();     ///< the corner (0, 0, 0) of the grid in the shape's frame
};

enum class ShapeKind : std::uint8_t {
  sphere, box, capsule, cylinder, cone, ellipsoid, halfspace, convex, triangle, mesh, plane, voxels
};
inline constexpr std::size_t shape_kinds = 12;

std::string_view name(ShapeKind kind);

namespace detail {
struct Hull;
struct MeshModel;
struct VoxelModel;
struct ShapeInsides;
struct SharedParts;
}  // namespace detail

/// An axis-aligned box in doubles, world axes.
struct Bounds {
  Vec3 lo;
  Vec3 hi;
};

/// Mass properties with density 1, about the centre of mass, in the shape's frame. For shapes without a volume
/// (triangle, open mesh, flat hull) those of the bounding box, widened to a hundredth of its size.
struct MassProperties {
  double volume;   ///< m^3
  Vec3 centre;     ///< m
  Mat3 inertia;    ///< m^5: multiply by density
};

/// Heap memory of a shape in bytes; copies share it.
struct ShapeMemory {
  std::size_t surface = 0;    ///< a mesh's vertices and triangles, or cells
  std::size_t adjacency = 0;  ///< which triangles are neighbours, which vertices coincide
  std::size_t hierarchy = 0;  ///< boxes, and the corners in single precision
  std::size_t hull = 0;       ///< of a convex or triangle; for a mesh 0 until a query has needed it
  std::size_t other = 0;

  std::size_t total() const { return surface + adjacency + hierarchy + hull + other; }
};

/// A checked shape, ready for queries; immutable, cheap to copy, safe to share between threads. Every constructor
/// throws std::invalid_argument that names the field, its value and what is allowed.
class Shape {
 public:
  Shape(const Sphere&);
  Shape(const Box&);
  Shape(const Capsule&);
  Shape(const Cylinder&);
  Shape(const Cone&);
  Shape(const Ellipsoid&);
  Shape(const HalfSpace&);  ///< normal and offset are divided by the normal's length
  Shape(const Plane&);      ///< as for HalfSpace
  explicit Shape(const Convex&);  ///< builds the hull
  Shape(const Triangle&);
  explicit Shape(Mesh);  ///< builds a hierarchy of boxes
  Shape(Mesh, const PartRunner& parts);  ///< the same, with the work distributed by `parts`
  /// Builds a hierarchy of boxes with these options; throws WorkStopped if the limit ended it.
  Shape(Mesh, const BuildOptions& options);
  /// Sorts the cells and builds a hierarchy of boxes: 20 bytes a cell. Eight that fill one twice as wide become that
  /// one: one set of points is one shape. Throws std::invalid_argument for a cell, size, origin or width not allowed.
  explicit Shape(const Voxels&);

  /// This shape with a ball of this radius (>= 0, finite, metres) about each of its points: a box with round edges, a
  /// thick triangle. A sphere, capsule or half-space becomes one of the same kind; for others the mass stays the
  /// core's.
  Shape rounded(double radius) const;
  double rounding() const { return rounding_; }  ///< metres; other parameters are the core's

  ShapeKind kind() const { return kind_; }
  bool is_convex() const { return kind_ != ShapeKind::mesh && kind_ != ShapeKind::voxels; }
  bool is_bounded() const { return kind_ != ShapeKind::halfspace && kind_ != ShapeKind::plane; }

  /// Parameters; each is defined for the kinds that have it, see the structs above.
  const std::array<double, 4>& parameters() const { return param_; }    ///< in the order below, then zeros
  double radius() const { return param_[0]; }
  double length() const { return param_[1]; }
  Vec3 half_size() const { return {param_[0], param_[1], param_[2]}; }  ///< box
  Vec3 radii() const { return {param_[0], param_[1], param_[2]}; }      ///< ellipsoid
  Vec3 normal() const { return {param_[0], param_[1], param_[2]}; }     ///< halfspace and plane, unit
  double offset() const { return param_[3]; }                           ///< halfspace, plane
  Vec3 origin() const { return {param_[0], param_[1], param_[2]}; }     ///< voxels
  double cell_size() const { return param_[3]; }                        ///< voxels
  /// Voxels: the cells in the order by which contacts name them, that of an octree's leaves (Morton's); else empty.
  std::span<const VoxelCell> cells() const;
  /// Convex: the corners of the hull, in the order given; triangle, mesh: as given; else empty.
  std::span<const Vec3> vertices() const;
  /// Triangle, mesh: corners as indices of vertices, else empty. Connected triangles of a mesh are oriented alike,
  /// those of a closed one counterclockwise as seen from outside.
  std::span<const std::array<std::uint32_t, 3>> triangles() const;
  bool is_solid() const;  ///< the inside counts too: true except for planes, triangles and meshes that are surfaces

  /// The smallest box in world axes that contains the posed shape (half-space, plane: +-1e300 on open sides).
  Bounds bounds(const Pose& pose) const { return bounds(pose, nullptr); }
  /// The same. A mesh's hull is built when its box is first asked for; the limit may end that: WorkStopped is thrown,
  /// and the next call builds it. Null: none.
  Bounds bounds(const Pose& pose, const WorkLimit* limit) const;
  /// The diagonal of the box in the shape's frame; the unit of relative errors. 0 for half-space, plane and a point.
  double size() const { return size_; }
  MassProperties mass() const;  ///< computed at the first call, from any thread; that of a sphere at each call
  ShapeMemory memory_by_part() const;
  std::size_t memory() const { return memory_by_part().total(); }  ///< heap memory in bytes

  /// Identifies a shape, never 0: equal for two shapes only if one is a copy of the other or both are spheres of the
  /// same radius.
  std::uint64_t identity() const;

 private:
  friend struct detail::ShapeInsides;

  Bounds core_bounds(const Pose& pose, const WorkLimit* limit) const;

  ShapeKind kind_;
  std::array<double, 4> param_{};
  double size_ = 0;
  double rounding_ = 0;
  // A single pointer, null for a sphere, since there may be a shape for each body.
  std::shared_ptr<const detail::SharedParts> parts_;
};

/// Two posed shapes, not owned.
struct PlacedPair {
  const Shape* a;
  const Pose* pose_a;
  const Shape* b;
  const Pose* pose_b;
};

}  // namespace tandem
