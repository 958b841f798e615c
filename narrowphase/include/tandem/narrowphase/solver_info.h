#pragma once
#include <cstdint>
#include <string_view>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// How sure a solver's answer is.
enum class Exactness : std::uint8_t {
  exact,        ///< decided on the real numbers R v + t
  rounding,     ///< right to rounding
  bounded,      ///< PairAnswer::error_bound says how far off it may be
  least_found,  ///< gaps: right to rounding; depth: the least that a search finds, which separates
  separating,   ///< gaps: right to rounding; depth: a translation that separates, error_bound says how far from the
                ///< shortest
  unknown,      ///< another library's
  refused,      ///< the request is not defined for the pair
};
std::string_view name(Exactness exactness);

/// One solver.
struct SolverInfo {
  std::string_view name;         ///< "closed", "sat", "gjk", "fcl", "libccd", "bvh", ...
  std::string_view description;  ///< one line, with its source
};

/// One row of the table from which a tolerance chooses: what a solver costs on a pair of kinds, and how far off it was
/// at most. Measured over separated, near, shallow, deep and hard pairs alike.
struct SolverRow {
  ShapeKind a, b;  ///< unordered
  Request request;
  std::string_view solver;  ///< by its name in `solvers()`
  double tolerance;         ///< that it is run with, relative to the bodies' size; 0: to rounding
  double nanoseconds;       ///< a query, mean of the classes; on one machine: good for comparing rows only
  double error;  ///< largest, of the signed distance (collide: of the gap it took for a touch, or a touch for
                 ///< a gap), relative to size
  Exactness exactness;
};

}  // namespace tandem
