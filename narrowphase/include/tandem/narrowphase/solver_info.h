// The table of solvers by kinds and request.
#pragma once
#include <cstdint>
#include <string_view>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The accuracy of a solver's answer.
enum class Exactness : std::uint8_t {
  exact,        ///< decided on the real numbers R v + t
  rounding,     ///< right to rounding
  bounded,      ///< PairAnswer::error_bound bounds the error
  least_found,  ///< distances: right to rounding; depth: the least that a search finds, which separates
  separating,   ///< gaps: right to rounding; depth: a translation that separates, error_bound says how far from the
                ///< shortest
  unknown,      ///< that of another library
  refused,      ///< the request is not defined for the pair
};
std::string_view name(Exactness exactness);

/// A solver.
struct SolverInfo {
  std::string_view name;         ///< "closed", "sat", "gjk", "fcl", "libccd", "bvh", ...
  std::string_view description;  ///< one line, with its source
};

/// A row of the table from which a tolerance chooses: the cost of a solver on a pair of kinds, and its largest error.
/// Measured over separated, near, shallow, deep and hard pairs alike.
struct SolverRow {
  ShapeKind a, b;  ///< unordered
  Request request;
  std::string_view solver;  ///< by its name in `solvers()`
  double tolerance;         ///< the tolerance that it is run with, relative to the bodies' size; 0: to rounding
  double nanoseconds;       ///< a query, mean of the classes, on one machine: only for comparing rows
  double error;  ///< largest, of the signed distance (collide: of the gap it took for a touch, or a touch for
                 ///< a gap), relative to size
  Exactness exactness;
};

}  // namespace tandem
