// Cyclic successor and predecessor of an axis of space, or of a corner of a triangle.
#pragma once

namespace tandem {

inline constexpr int next_of_three[3] = {1, 2, 0}, last_of_three[3] = {2, 0, 1};

}  // namespace tandem
