// Candidate pairs of bodies with renewed boxes.
#pragma once
#include "kept_candidates/returned_bodies.h"

namespace tandem {

/// Candidate pairs of bodies that were put back (ReturnedBodies): each body with the others that it may overlap.
struct ReturnedCandidates {
  struct Entry {
    std::uint32_t body, turn;  ///< see ReturnedBodies
    std::size_t end;           ///< end of its bodies in `others`
  };
  std::vector<Entry> entries;
  std::vector<std::uint32_t> others;
  std::size_t kept = 0;  ///< size of `others` after the last removal

  void clear() {
    entries.clear();
    others.clear();
    kept = 0;
  }
  /// Removes the pairs that later entries hold, too, once these may be half of all.
  void forget(const ReturnedBodies& returned);
  void close(std::uint32_t body, std::uint32_t turn) {
    if (others.size() != (entries.empty() ? 0 : entries.back().end)) entries.push_back({body, turn, others.size()});
  }
  std::size_t memory() const { return bytes_of(entries) + bytes_of(others); }
};

}  // namespace tandem
