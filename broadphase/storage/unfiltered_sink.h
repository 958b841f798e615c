// Sinks that take pairs block by block.
#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "tandem/broadphase/pair.h"

namespace tandem {

/// A sink that collects the pairs of a method without filtering them, since it filters or tests them itself: `size` at
/// a time.
template <std::size_t size>
class UnfilteredSink : public PairSink {
 public:
  /// Handles the pairs that are left.
  void flush() {
    take(std::span<const Pair>(room_).first(count_));
    count_ = 0;
  }

 protected:
  UnfilteredSink() {
    filter_ = &everything_;
    buffer_ = room_.data();
    capacity_ = size;
  }
  UnfilteredSink(const UnfilteredSink&) = delete;
  UnfilteredSink& operator=(const UnfilteredSink&) = delete;

  virtual void take(std::span<const Pair> pairs) = 0;

 private:
  void full() final { flush(); }

  const PairFilter everything_{};
  std::array<Pair, size> room_;
};

}  // namespace tandem
