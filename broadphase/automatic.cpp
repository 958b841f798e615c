#include "automatic.h"

namespace tandem {

std::size_t Automatic::begin(const BoxArray& boxes) {
  method_ = &choose(boxes.size());
  last_size_ = boxes.size();
  reason_while_kept_ = reason_ + "; its candidates kept";
  return list_.begin(boxes, *method_);
}

ListedMethod& Automatic::choose(std::size_t n) {
  const std::string count = std::to_string(n) + " boxes";
  if (n < sweep_below) {
    const bool brute = n < brute_below;
    reason_ =
        (brute ? "brute: " : "sweep: ") + count + ", fewer than " + std::to_string(brute ? brute_below : sweep_below);
    tree_steps_left_ = 0;
    if (brute) return brute_;
    return sweep_;
  }

  if (method_ == &grid_ && list_.method_ran()) {
    const Grid::Unfit unfit = grid_.unfit();
    const bool many_large = unfit.large > last_size_ / 8;
    if (unfit.crowded || many_large) {
      tree_steps_left_ = tree_steps;
      unfit_reason_ = unfit.crowded
                          ? "bvh: boxes cluster, a column of the grid held " + std::to_string(unfit.longest_column)
                          : "bvh: sizes spread, " + std::to_string(unfit.large) + " were large for the grid";
      unfit_reason_ += " at " + std::to_string(last_size_) + " boxes";
    }
  }
  if (tree_steps_left_ > 0) {
    --tree_steps_left_;
    if (n < brute_in_crowds_below) {
      reason_ = "brute instead of " + unfit_reason_ + ", fewer than " + std::to_string(brute_in_crowds_below);
      return brute_;
    }
    reason_ = unfit_reason_;
    return bvh_;
  }
  reason_ = "grid: " + count + ", at least " + std::to_string(sweep_below);
  return grid_;
}

}  // namespace tandem
