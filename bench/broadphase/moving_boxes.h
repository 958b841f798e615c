// Worlds of moving boxes for the broad-phase bench.
#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/broadphase/box_array.h"

namespace tandem::bench {

/// A world of boxes that move; each call of `move` is a step. Deterministic by name, number and step.
class MovingBoxes {
 public:
  virtual ~MovingBoxes() = default;
  const BoxArray& boxes() const { return boxes_; }
  /// Flags of boxes that never move, where pairs of two of these are not wanted; else empty.
  std::span<const std::uint8_t> is_static() const { return is_static_; }
  /// One byte a box, 0 where the box never changes; empty: all may change.
  std::span<const std::uint8_t> changes() const { return changes_; }
  void move() { move(++step_); }

 protected:
  virtual void move(int step) = 0;
  BoxArray boxes_;
  std::vector<std::uint8_t> is_static_, changes_;

 private:
  int step_ = 0;
};

struct BoxWorkload {
  std::string_view name;
  std::string_view text;
  std::size_t most = 0;   ///< largest number of boxes, for worlds where all pairs overlap; 0: any number
  bool breaking = false;  ///< made to break broad phases, not to be typical
};

/// W1 to W4, the typical worlds, then those made to break broad phases.
std::span<const BoxWorkload> box_workloads();

/// Makes a world of about n boxes. Throws std::invalid_argument for an unknown name.
std::unique_ptr<MovingBoxes> make_moving_boxes(std::string_view name, std::size_t n);

}  // namespace tandem::bench
