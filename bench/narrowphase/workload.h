// Workloads of the narrow-phase bench: pairs with their reference answers.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pair_classes.h"
#include "reference.h"

namespace tandem::bench {

/// Pairs of one kind and class, with the reference's answers.
struct Workload {
  std::string kind, pair_class;
  std::vector<reference::PosedPair> pairs;
  std::vector<reference::Truth> truths;
  std::size_t tracks = 0;  ///< > 0: pair i + tracks is pair i one time step later
};

/// The first `n` pairs of a class. Uses every thread of the arena; the same bits on any number of threads.
Workload make_workload(reference::PairKind kind, reference::PairClass pair_class, std::size_t n);

/// About n pairs: tracks of 20 steps on which B drifts and turns by 2 % of its size and 0.02 rad a step, from a gap of
/// about a tenth of its size through A.
Workload make_motion(reference::PairKind kind, std::size_t n);

/// The pair at `index` of a workload of `n` pairs, by the names of its kind and class ("motion" too); empty if there is
/// none.
std::optional<reference::PosedPair> named_pair(std::string_view kind, std::string_view pair_class, std::size_t n,
                                               std::size_t index);

}  // namespace tandem::bench
