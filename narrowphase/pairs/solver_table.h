// The table kinds x request: the method that answers two kinds, the accuracy of its answer, and other properties of the
// pair. The dispatch, `solver_for`, the choice by tolerance, refused requests, and the table of docs/solvers.md are
// read from it.
#pragma once
#include <span>
#include <string>

#include "pairs/methods.h"
#include "pairs/simple_pairs.h"
#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/solver_info.h"

namespace tandem {

/// A test that answers Request::collide before the pair's method is tried.
enum class CollideTest : std::uint8_t { none, unbounded, triangles, box_triangle };

/// Groups of pairs that a step solves several at a time, a pair a lane.
enum class LaneGroup : std::uint8_t { none, spheres, halfspace_sphere, boxes, halfspace_box };

/// The solver of two kinds, in the order A, B.
struct PairSolver {
  Method method;         ///< exact to rounding if there is such a method, and the cheapest of those
  CollideTest collides;  ///< tried first for Request::collide
  LaneGroup lanes;
  std::array<Exactness, 3> exactness;  ///< accuracy by request
  DirectSolver* direct;                ///< straight from the parameters; null if the pair must be prepared
  bool one_verdict;                    ///< all requests decide collision by the same tests, exact ones or cell by cell
};

extern const std::array<std::array<PairSolver, shape_kinds>, shape_kinds> pair_solvers;
inline const PairSolver& pair_solver(ShapeKind a, ShapeKind b) {
  return pair_solvers[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
}

/// True if the request is undefined for the pair.
inline bool is_refused(const PairSolver& pair, Request request) {
  return pair.exactness[static_cast<std::size_t>(request)] == Exactness::refused;
}

/// True if the method can answer this (unordered) pair of kinds.
bool covers(Method method, ShapeKind a, ShapeKind b);

/// The accuracy of a method's answer for the (unordered) pair, which it covers.
Exactness exactness(Method method, ShapeKind a, ShapeKind b, Request request);

/// The method that the options choose for the (unordered) pair: the solver they name if it covers the pair, else the
/// cheapest measured row whose error is within their tolerance, else the pair's own method.
struct MethodChoice {
  Method method;
  double tolerance;      ///< the tolerance that it is run with
  const SolverRow* row;  ///< measured; null if there is none
};
MethodChoice choose_method(ShapeKind a, ShapeKind b, Request request, const NarrowPhaseOptions& options);

/// The measured rows, by pair of kinds and request, the cheapest first.
std::span<const SolverRow> solver_rows();

}  // namespace tandem
