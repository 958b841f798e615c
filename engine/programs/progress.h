// A progress bar on the terminal.
#pragma once
#include <chrono>
#include <cstdint>
#include <string_view>

namespace tandem {

/// A progress bar on stderr, if stderr is a terminal; it overwrites itself and disappears at the end.
class Progress {
 public:
  /// `total` 0: the amount is unknown, and there is no bar.
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
