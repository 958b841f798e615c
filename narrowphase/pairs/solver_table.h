// The table kinds x request: which method answers which two kinds, how sure its answer is, and what else is known of
// the pair. The dispatch, `solver_for`, the tolerance, what is refused, and the table of docs/solvers.md are read from
// it.
#pragma once
#include <span>
#include <string>

#include "pairs/methods.h"
#include "pairs/simple_pairs.h"
#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/solver_info.h"

namespace tandem {

/// A test that answers Request::collide before the pair's method is asked.
enum class CollideTest : std::uint8_t { none, unbounded, triangles, box_triangle };

/// Pairs that a step solves several at a time, a pair a lane.
enum class LaneGroup : std::uint8_t { none, spheres, halfspace_sphere, boxes, halfspace_box };

/// How two kinds are solved, as A and B stand.
struct PairSolver {
  Method method;         ///< right to rounding where there is one, and cheapest among those
  CollideTest collides;  ///< asked first where a yes/no is wanted
  LaneGroup lanes;
  std::array<Exactness, 3> exactness;  ///< by request
  DirectSolver* direct;                ///< straight from the parameters; null where the pair is to be prepared
};

extern const std::array<std::array<PairSolver, shape_kinds>, shape_kinds> pair_solvers;
inline const PairSolver& pair_solver(ShapeKind a, ShapeKind b) {
  return pair_solvers[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
}

/// Is the request defined for the (unordered) pair?
inline bool is_refused(ShapeKind a, ShapeKind b, Request request) {
  return pair_solver(a, b).exactness[static_cast<std::size_t>(request)] == Exactness::refused;
}

/// Does the method answer this (unordered) pair of kinds?
bool covers(Method method, ShapeKind a, ShapeKind b);

/// How sure a method's answer is for the (unordered) pair, which it covers.
Exactness exactness(Method method, ShapeKind a, ShapeKind b, Request request);

/// What the options choose for the (unordered) pair: the solver that they name where it covers the pair, else the
/// cheapest measured row whose error is within their tolerance, else the pair's own method.
struct MethodChoice {
  Method method;
  double tolerance;      ///< that it is run with
  const SolverRow* row;  ///< measured; null if there is none
};
MethodChoice choose_method(ShapeKind a, ShapeKind b, Request request, const NarrowPhaseOptions& options);

/// The measured rows: by pair of kinds and request, the cheapest first.
std::span<const SolverRow> solver_rows();

}  // namespace tandem
