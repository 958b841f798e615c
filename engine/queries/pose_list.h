// Access to the poses of a batch in place.
#pragma once
#include <concepts>
#include <cstddef>
#include <cstring>
#include <span>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// Consecutive poses in memory: C++ poses, or homogeneous matrices in row-major order, as numpy has them.
class PoseList {
 public:
  PoseList() = default;
  template <std::convertible_to<std::span<const Pose>> Poses>
  PoseList(const Poses& poses) {
    static_assert(sizeof(Pose) == 12 * sizeof(double));  // the rotation's columns, the translation
    const std::span<const Pose> all(poses);
    if (!all.empty()) numbers_ = all.front().rotation.data();
    size_ = all.size();
  }
  static PoseList of_matrices(std::span<const double> numbers) {
    PoseList list;
    list.numbers_ = numbers.data();
    list.size_ = numbers.size() / 16;
    list.matrices_ = true;
    return list;
  }

  std::size_t size() const { return size_; }
  /// True: the values are the rows of [rotation | translation] and a fourth row; false: columns and the translation.
  bool are_matrices() const { return matrices_; }
  const double* numbers(std::size_t i) const { return numbers_ + i * stride(); }
  std::size_t stride() const { return matrices_ ? 16 : 12; }
  Pose operator[](std::size_t i) const {
    Pose pose;
    const double* from = numbers(i);
    if (!matrices_) {
      std::memcpy(pose.rotation.data(), from, 9 * sizeof(double));
      std::memcpy(pose.translation.data(), from + 9, 3 * sizeof(double));
      return pose;
    }
    for (int row = 0; row < 3; ++row, from += 4) {
      for (int column = 0; column < 3; ++column) pose.rotation(row, column) = from[column];
      pose.translation[row] = from[3];
    }
    return pose;
  }
  /// True if the fourth row of a matrix is 0, 0, 0, 1.
  bool has_last_row(std::size_t i) const {
    const double* m = numbers(i);
    return !matrices_ || ((m[12] == 0) & (m[13] == 0) & (m[14] == 0) & (m[15] == 1)) != 0;
  }
  /// The poses from `first` on.
  PoseList from(std::size_t first) const {
    PoseList list = *this;
    list.numbers_ = numbers(first);
    list.size_ -= first;
    return list;
  }

 private:
  const double* numbers_ = nullptr;
  std::size_t size_ = 0;
  bool matrices_ = false;
};

}  // namespace tandem
