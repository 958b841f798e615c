// Generalised winding numbers, and solids from open meshes.
#pragma once
#include <cstddef>
#include <memory>
#include <vector>

#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

struct VoxelSolidOptions;

/// The generalised winding number of a mesh's triangles, as they are given: the sum of their signed solid angles over 4
/// pi. About a closed mesh it is how often the surface goes round a place, counterclockwise seen from outside: 1
/// inside, 0 outside. Where there are holes it changes evenly through them and jumps by 1 at the surface: nearer to 1
/// where more of what is seen is the inside (Jacobson, Kavan and Sorkine-Hornung, Robust inside-outside segmentation
/// using generalized winding numbers, 2013). Turned triangles count negative, those that are there twice count twice.
///
/// Right to rounding, without an approximation: seen from outside of its box, a subtree of the hierarchy has the solid
/// angle of any surface with the same border. Immutable, cheap to copy, safe to share between threads.
class WindingNumber {
 public:
  /// Throws std::invalid_argument, as Shape does, for data that are not a mesh. `mesh.solid` does not matter.
  explicit WindingNumber(const Mesh& mesh);

  /// The winding number at a point in the mesh's frame, finite; on the surface any number between those on its two
  /// sides.
  double at(const Vec3& place) const;

 private:
  friend Shape voxel_solid(const Mesh& mesh, const VoxelSolidOptions& options);
  struct Insides;
  std::shared_ptr<const Insides> insides_;
};

struct VoxelSolidOptions {
  double size = 0;  ///< edge of a cell, metres, > 0
  /// Winding number from which on a cell's centre counts as inside, finite.
  double least = 0.5;
  std::size_t most_cells = std::size_t{1} << 24;  ///< cells of the mesh's box; more are refused
  const WorkLimit* limit = nullptr;               ///< ends the work (work_limit.h): WorkStopped is thrown. Null: none
};

/// A solid for a mesh that need not be closed: the cubes of a grid whose centres have at least that winding number, as
/// made by `voxel_mesh`, in the mesh's frame. For a closed mesh its surface is within half a cell's diagonal of the
/// mesh's; parts thinner than a cell may be missing. Over a hole it is closed where the winding number crosses `least`,
/// which is a guess that the caller asked for. Throws std::invalid_argument for a bad option, too many cells, or if no
/// cell is inside, as for a mesh that is inside out.
Shape voxel_solid(const Mesh& mesh, const VoxelSolidOptions& options);

}  // namespace tandem
