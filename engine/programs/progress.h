// A progress bar on the terminal.
#pragma once
#include <chrono>
#include <concepts>
#include <cstdint>
#include <string_view>

namespace tandem {

/// A progress bar on stderr, if stderr is a terminal; it overwrites itself and disappears at the end.
class Progress {
 public:
  /// `total` >= 0; 0: the amount is unknown, and there is no bar.
  template <std::integral Count>
  Progress(std::string_view what, Count total) : what_(what), total_(static_cast<std::uint64_t>(total)) {
    find_terminal();
  }
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  template <std::integral Count>
  void at(Count done) {
    if (shown_) draw(static_cast<std::uint64_t>(done));
  }

 private:
  void find_terminal();
  void draw(std::uint64_t done);

  std::string_view what_;
  std::uint64_t total_;
  bool shown_ = false;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace tandem
