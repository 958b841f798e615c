#pragma once
#include "kept_candidates/returned_bodies.h"

namespace tandem {

/// What bodies that were put back may meet.
struct ReturnedCandidates {
  struct Entry {
    std::uint32_t body, turn;  ///< see ReturnedBodies
    std::size_t end;           ///< of its bodies in `others`
  };
  std::vector<Entry> entries;
  std::vector<std::uint32_t> others;
  std::size_t kept = 0;  ///< of `others` when some were last dropped

  void clear() {
    entries.clear();
    others.clear();
    kept = 0;
  }
  /// Drops what later ones hold, once that may be half.
  void forget(const ReturnedBodies& returned);
  void close(std::uint32_t body, std::uint32_t turn) {
    if (others.size() != (entries.empty() ? 0 : entries.back().end)) entries.push_back({body, turn, others.size()});
  }
  std::size_t memory() const { return bytes_of(entries) + bytes_of(others); }
};

}  // namespace tandem
