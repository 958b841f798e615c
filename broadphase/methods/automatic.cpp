// Chooses the broad phase of each step.
#include "methods/automatic.h"

#include <initializer_list>
#include <string_view>

namespace tandem {
namespace {

/// Writes text into a string whose storage is kept from step to step.
void write(std::string& text, std::initializer_list<std::string_view> parts) {
  text.clear();
  for (const std::string_view part : parts) text.append(part);
}

}  // namespace

std::size_t Automatic::begin(const BoxArray& boxes) {
  method_ = &choose(boxes.size());
  last_size_ = boxes.size();
  write(reason_while_kept_, {reason_, "; its candidates kept"});
  return list_.begin(boxes, *method_);
}

ListedMethod& Automatic::choose(std::size_t n) {
  const std::string count = std::to_string(n);
  if (n < sweep_below) {
    const bool brute = n < brute_below;
    write(reason_, {brute ? "brute: " : "sweep: ", count, " boxes, fewer than ",
                    std::to_string(brute ? brute_below : sweep_below)});
    tree_steps_left_ = 0;
    if (brute) return brute_;
    return sweep_;
  }

  if (method_ == &grid_ && list_.method_ran()) {
    const Grid::Unfit unfit = grid_.unfit();
    const bool many_large = unfit.large > last_size_ / 8;
    if (unfit.crowded || many_large) {
      tree_steps_left_ = tree_steps;
      if (unfit.crowded)
        write(unfit_reason_,
              {"bvh: boxes cluster, a column of the grid held ", std::to_string(unfit.longest_column), " at "});
      else
        write(unfit_reason_, {"bvh: sizes spread, ", std::to_string(unfit.large), " were large for the grid at "});
      unfit_reason_.append(std::to_string(last_size_)).append(" boxes");
    }
  }
  if (tree_steps_left_ > 0) {
    --tree_steps_left_;
    if (n < brute_in_crowds_below) {
      write(reason_, {"brute instead of ", unfit_reason_, ", fewer than ", std::to_string(brute_in_crowds_below)});
      return brute_;
    }
    reason_ = unfit_reason_;
    return bvh_;
  }
  write(reason_, {"grid: ", count, " boxes, at least ", std::to_string(sweep_below)});
  return grid_;
}

}  // namespace tandem
