#pragma once
#include <chrono>
#include <cstdint>
#include <string_view>

namespace tandem {

/// A bar on stderr that overwrites itself, when stderr is a terminal; else nothing. Gone when it ends.
class Progress {
 public:
  /// `total` 0: the amount is not known, and there is no bar.
  Progress(std::string_view what, std::uint64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void at(std::uint64_t done);

 private:
  std::string_view what_;
  std::uint64_t total_;
  bool shown_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace tandem
