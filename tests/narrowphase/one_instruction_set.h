// Restricts kernels to one instruction set.
#pragma once
#include <hwy/targets.h>
#include <cstdint>

namespace tandem::test {

/// Restricts kernels to one instruction set while it lives.
class OneInstructionSet {
 public:
  explicit OneInstructionSet(std::int64_t target) { choose(target); }
  ~OneInstructionSet() { choose(0); }
  OneInstructionSet(const OneInstructionSet&) = delete;
  OneInstructionSet& operator=(const OneInstructionSet&) = delete;

 private:
  static void choose(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

}  // namespace tandem::test
