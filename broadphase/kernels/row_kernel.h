// Kernel that tests one box against a range of boxes.
#pragma once
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Tests `box` against boxes[begin, end) and writes the indices of those it overlaps to `out`, ascending; returns how
/// many. `out` needs room for end - begin + BoxArray::padding elements. The kernel is chosen at run time for the widest
/// instruction set of the processor (SSE2 to AVX-512); they all give the same answer.
///
/// It is not inlined on purpose: with the output of pairs inside the vector loop the same work took up to twice as
/// long. Hits are stored as indices here and turned into pairs by the caller.
std::size_t overlap_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box, std::uint32_t* out);

/// Writes to `out` the indices, ascending, of the boxes [begin, end) whose squared distance from `box` is finite and at
/// most `most`, and these squares to `squared`; returns how many. Both need the room that overlap_row's `out` needs.
/// All instruction sets give the same bits.
std::size_t near_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box, double most,
                     std::uint32_t* out, double* squared);

/// The union of each eight boxes of `below`, the last group may have fewer: above[first, last) from below[8 first, 8
/// last).
void unite_rows(const BoxArray& below, std::size_t first, std::size_t last, BoxArray& above);

}  // namespace tandem
