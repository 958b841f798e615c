// The choice of the batch size.
#pragma once
#include <cstddef>

#include "answers/ordered_answers.h"
#include "tandem/flowgraph/report.h"

namespace tandem {

/// Chooses the batch size from the last step's cost of a pair: 15 us of narrow work, up to 120 us in long steps, at
/// most what the user allows. On the caller alone, where no batch is handed on, the user's limit.
class BatchSize {
 public:
  explicit BatchSize(std::size_t most) : most_(most), size_{.most = most, .heavy = 1} {}
  BatchPairs get(StepForm form) const { return form == StepForm::caller ? BatchPairs{.most = most_} : size_; }
  void learn(const ExecutionReport& report);

 private:
  std::size_t most_;
  BatchPairs size_;
};

}  // namespace tandem
