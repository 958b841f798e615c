// The progress of building a mesh, and its limit.
#pragma once
#include <atomic>
#include <cstddef>

#include "tandem/narrowphase/build_options.h"

namespace tandem {

/// Counts the work of building; shared by the threads that build.
class BuildMeter {
 public:
  /// For this much work in all; `options` must outlive it.
  BuildMeter(const BuildOptions& options, std::size_t work) : options_(options), work_(work) {}

  /// Counts work that is done. Throws WorkStopped once the limit is reached.
  void spend(std::size_t work);

  /// Reports the end.
  void finish();

 private:
  void report_progress(std::size_t done);

  static constexpr std::size_t times = 100;  ///< reports of progress at most

  const BuildOptions& options_;
  const std::size_t work_;
  std::atomic<std::size_t> done_{0};
  std::atomic<bool> telling_{false};
  std::size_t reported_ = 0;
};

}  // namespace tandem
