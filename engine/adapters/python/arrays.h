// Conversions between numpy arrays and vectors, poses and indices.
#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem::python {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style>;

/// A number with all its digits, for messages.
std::string written(double x);

/// The argument as contiguous doubles: itself if it is such an array, else a copy of any array or sequence of real
/// numbers. Throws std::invalid_argument "WHAT: ..." for anything else.
Doubles doubles(const py::handle& value, std::string_view what);
/// As above for an array of a given shape; -1 in it allows any length.
Doubles doubles(const py::handle& value, std::string_view what, std::initializer_list<py::ssize_t> shape);

Vec3 vec3(const py::handle& value, std::string_view what);
/// Points from an array (n, 3).
std::vector<Vec3> points(const py::handle& value, std::string_view what);
/// Integers that fit Index, from an array (n, N); N: 3 for triangles and cells of a grid, 4 for pairs of features.
template <class Index, std::size_t N>
std::vector<std::array<Index, N>> index_rows(const py::handle& value, std::string_view what);
/// A pose. None: the identity. (4, 4): homogeneous. (7): translation, then quaternion w, x, y, z. Throws if it is not a
/// pose.
Pose pose(const py::handle& value, std::string_view what);
/// Poses as they were passed, (..., 4, 4) or (..., 7), in order: converted when they are needed, since copying all of a
/// large batch would take noticeable time. The called function checks whether they are rotations.
class PoseRows {
 public:
  /// Throws std::invalid_argument for an array of another shape.
  PoseRows(const py::handle& value, std::string_view what);
  std::size_t size() const { return size_; }
  /// The numbers of (..., 4, 4), else empty.
  std::span<const double> matrices() const { return {numbers_, matrices_ ? 16 * size_ : 0}; }
  /// Converts the poses from `first` on; without the GIL, from any thread. Throws std::invalid_argument if one is not a
  /// pose.
  void read(std::size_t first, std::span<Pose> out) const;

 private:
  Doubles array_;
  const double* numbers_;
  std::string what_;
  bool matrices_;
  std::size_t size_;
};
/// All poses of an array.
std::vector<Pose> poses(const py::handle& value, std::string_view what);

Doubles to_array(const Vec3& v);
Doubles to_array(const Mat3& matrix);  ///< (3, 3)
Doubles to_array(const std::array<double, 4>& numbers);
Doubles to_array(const Pose& pose);              ///< (4, 4)
Doubles to_array(std::span<const Pose> poses);   ///< (n, 4, 4)
Doubles to_array(std::span<const Vec3> points);  ///< (n, 3)
py::array_t<std::uint32_t> to_array(std::span<const std::array<std::uint32_t, 3>> triangles);
py::array_t<std::uint32_t> to_array(std::span<const std::array<std::uint32_t, 2>> pairs);

}  // namespace tandem::python
