#pragma once
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Tests `box` against boxes[begin, end) and writes the indices of those it overlaps to `out`, ascending; returns
/// how many. `out` needs room for end - begin + BoxArray::padding elements. The kernel is chosen at run time from
/// the widest instruction set of the processor (SSE2 to AVX-512); they all give the same answer.
///
/// It stays out of line on purpose: with the pair output inlined into the vector loop the same work took up to twice
/// as long. Hits are compress-stored here and turned into pairs by the caller.
std::size_t overlap_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box, std::uint32_t* out);

/// Writes the indices of those of boxes[begin, end) to `out` whose distance from `box`, squared, is finite and at most
/// `most`, ascending, and these squares to `squared`; returns how many. Both need the room that overlap_row's `out`
/// needs. The same bits by every instruction set.
std::size_t near_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box, double most,
                     std::uint32_t* out, double* squared);

/// The box around each eight of `below`, the last ones fewer: above[first, last) from below[8 first, 8 last).
void unite_rows(const BoxArray& below, std::size_t first, std::size_t last, BoxArray& above);

}  // namespace tandem
