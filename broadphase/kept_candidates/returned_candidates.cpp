// Candidate pairs of bodies that were put back; drops those that later entries replace.
#include "kept_candidates/returned_candidates.h"

#include <utility>

namespace tandem {

void ReturnedCandidates::forget(const ReturnedBodies& returned) {
  if (others.size() <= 2 * kept + 64) return;
  std::size_t first = 0, end = 0, entry_count = 0;
  for (Entry entry : entries) {
    const std::size_t begin = std::exchange(first, entry.end);
    if (returned.turn(entry.body) != entry.turn) continue;
    const std::size_t mine = end;
    for (std::size_t k = begin; k < first; ++k)
      if (returned.turn(others[k]) <= entry.turn) others[end++] = others[k];
    entry.end = end;
    if (end != mine) entries[entry_count++] = entry;
  }
  entries.resize(entry_count);
  others.resize(end);
  kept = end;
}

}  // namespace tandem
