// The axis of space, or the corner of a triangle, that comes after or before one of the three in turn.
#pragma once

namespace tandem {

inline constexpr int next_of_three[3] = {1, 2, 0}, last_of_three[3] = {2, 0, 1};

}  // namespace tandem
