#pragma once
#include <limits>
#include <memory_resource>
#include <string>

#include "tandem/narrowphase/part_runner.h"

namespace tandem {

struct WorkLimit;

struct NarrowPhaseOptions {
  /// Error the user accepts, relative to the bodies' size, [0, 0.1]; 0: to rounding. The cheapest solver of the
  /// table that meets it is taken.
  double tolerance = 0;
  /// Request::contacts also reports gaps up to this, as negative depths (metres, finite, >= 0). Two meshes that
  /// intersect report what intersects alone.
  double margin = 0;
  /// Request::distance tells of pairs farther apart than this (metres, >= 0, infinity is allowed) no more than that:
  /// PairAnswer::farther. What is farther is left out of hierarchies.
  double cutoff = std::numeric_limits<double>::infinity();
  /// Forces the solver of that name (`solvers()` lists them) wherever it covers the pair; empty: the table's choice.
  std::string solver{};
  /// Shares the work on a pair of very large meshes, by subtrees; the answer does not depend on it. Empty: the caller.
  PartRunner parts{};
  /// Request::contacts says of two meshes that are apart how far at least. False: it says 0, which saves up to a
  /// twelfth of the time of those that nearly touch; but where a margin counts between them (`mesh_margin`) it says
  /// that all the same, as it is found then anyway.
  bool mesh_gaps = true;
  /// Request::contacts proves of a mesh that moving by the deepest contact separates it from what it collides with, or
  /// replaces that contact, and bounds the error. False: Status::unproven; saves a yes/no and some distances of points
  /// a pair, and hundredfold that of meshes deep in each other.
  bool mesh_bounds = true;
  /// Whether the margin counts between two meshes. False: they report what intersects alone; many pairs of triangles
  /// lie within a margin that is not small beside them, and to look at them takes up to ten times as long.
  bool mesh_margin = true;
  /// Ends work on a pair before it is done (work_limit.h), from this thread or another; must outlive the queries. Null:
  /// none. Without it, and as long as it is not reached, it changes no bit.
  const WorkLimit* limit = nullptr;
  /// Where contacts with meshes take memory that what is on the stack does not suffice for; given back before the call
  /// returns. Used by one call at a time: calls from several threads need options each. Must outlive the queries. It
  /// changes no bit. Null: std::pmr::get_default_resource().
  std::pmr::memory_resource* memory = nullptr;
};

}  // namespace tandem
