// A progress bar on the terminal.
#include "progress.h"

#include <unistd.h>

#include <cstdio>
#include <string>

namespace tandem {

void Progress::find_terminal() { shown_ = total_ > 0 && ::isatty(STDERR_FILENO) == 1; }

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::draw(std::uint64_t done) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  constexpr std::size_t width = 40;
  const auto full =
      static_cast<std::size_t>(static_cast<double>(width) * static_cast<double>(done) / static_cast<double>(total_));
  const std::string bar = std::string(full, '#') + std::string(width - full, '.');
  std::fprintf(stderr, "\r%.*s [%s] %llu/%llu", static_cast<int>(what_.size()), what_.data(), bar.c_str(),
               static_cast<unsigned long long>(done), static_cast<unsigned long long>(total_));
  drawn_ = true;
}

}  // namespace tandem
