// How far the building of a mesh is, and whether it is to go on.
#pragma once
#include <atomic>
#include <cstddef>

#include "tandem/narrowphase/build_options.h"

namespace tandem {

/// Shared by the threads that build.
class BuildMeter {
 public:
  /// Of so much work; `options` outlive it.
  BuildMeter(const BuildOptions& options, std::size_t work) : options_(options), work_(work) {}

  /// After so much more work. Throws WorkStopped once the limit is reached.
  void spend(std::size_t work);

  /// All is done.
  void finish();

 private:
  void tell(std::size_t done);

  static constexpr std::size_t times = 100;  ///< that progress is told, at most

  const BuildOptions& options_;
  const std::size_t work_;
  std::atomic<std::size_t> done_{0};
  std::atomic<bool> telling_{false};
  std::size_t told_ = 0;
};

}  // namespace tandem
