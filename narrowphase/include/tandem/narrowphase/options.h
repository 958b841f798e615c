// Options of narrow-phase queries.
#pragma once
#include <limits>
#include <memory_resource>
#include <string>

#include "tandem/narrowphase/part_runner.h"

namespace tandem {

struct WorkLimit;

struct NarrowPhaseOptions {
  /// The error that the user accepts, relative to the bodies' size, [0, 0.1]; 0: to rounding. Selects the cheapest
  /// solver of the table that meets it.
  double tolerance = 0;
  /// Request::contacts also reports points up to this distance, with negative depths (metres, finite, >= 0). Two meshes
  /// that intersect report only their intersections.
  double margin = 0;
  /// Request::distance reports of pairs farther apart than this (metres, >= 0, infinity is allowed) only that they are:
  /// PairAnswer::farther. Farther parts of hierarchies are skipped.
  double cutoff = std::numeric_limits<double>::infinity();
  /// Forces the solver of that name (`solvers()` lists them) wherever it covers the pair; empty: the choice of the
  /// table.
  std::string solver{};
  /// Distributes the work on a pair of very large meshes over threads, by subtrees; the answer does not depend on it.
  /// Empty: the caller does all of it.
  PartRunner parts{};
  /// Request::contacts gives a lower bound on the distance of two separated meshes. False: it gives 0, which saves up
  /// to a twelfth of the time of those that nearly touch; where a margin counts between them (`mesh_margin`) the bound
  /// is given all the same, since it is found anyway.
  bool mesh_gaps = true;
  /// Request::contacts with a mesh proves that a translation by the deepest contact separates the pair, or replaces
  /// that contact, and bounds the error of the depth. False: Status::unproven; saves a collision verdict and some
  /// distances of points for each pair, and a hundred times that for meshes deep in each other.
  bool mesh_bounds = true;
  /// The margin counts between two meshes. False: they report only their intersections; many pairs of triangles lie
  /// within a margin that is not small relative to them, and to examine these takes up to ten times as long.
  bool mesh_margin = true;
  /// Ends work on a pair before it is done (work_limit.h), from this thread or another; must outlive the queries. Null:
  /// none. Until it is reached it does not change any bit.
  const WorkLimit* limit = nullptr;
  /// Memory for contacts with meshes, and for the direction between meshes that touch, beyond what fits on the stack;
  /// released before the call returns. Used by one call at a time: calls from several threads need separate options.
  /// Must outlive the queries. Does not change any bit. Null: std::pmr::get_default_resource().
  std::pmr::memory_resource* memory = nullptr;
};

}  // namespace tandem
