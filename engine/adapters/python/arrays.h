#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem::python {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style>;

/// What was passed as contiguous doubles: itself where it is such an array, else a copy of any array or sequence of
/// real numbers. Throws std::invalid_argument "WHAT: ..." for anything else.
Doubles doubles(const py::handle& value, std::string_view what);
/// The same of a shape; -1 in it allows any length.
Doubles doubles(const py::handle& value, std::string_view what, std::initializer_list<py::ssize_t> shape);

Vec3 vec3(const py::handle& value, std::string_view what);
/// (n, 3)
std::vector<Vec3> points(const py::handle& value, std::string_view what);
/// (n, N) whole numbers in [0, 2^32); N: 3 for triangles, 4 for pairs of features
template <std::size_t N>
std::vector<std::array<std::uint32_t, N>> index_rows(const py::handle& value, std::string_view what);
/// None: the identity. (4, 4): homogeneous. (7): translation, then quaternion w, x, y, z. Throws where it is not a
/// pose.
Pose pose(const py::handle& value, std::string_view what);
/// Poses that were made where they are: a vector would write each twice, which a batch of many would feel.
class Poses {
 public:
  explicit Poses(std::size_t size)
      : storage_(std::make_unique_for_overwrite<std::byte[]>(size * sizeof(Pose))), size_(size) {}
  void make(std::size_t i, const Pose& pose) { std::construct_at(data() + i, pose); }
  std::size_t size() const { return size_; }
  operator std::span<const Pose>() const { return {data(), size_}; }

 private:
  static_assert(std::is_trivially_destructible_v<Pose> && alignof(Pose) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
  Pose* data() const { return reinterpret_cast<Pose*>(storage_.get()); }
  std::unique_ptr<std::byte[]> storage_;
  std::size_t size_;
};
/// (..., 4, 4) or (..., 7), in order. Whether they are rotations is for the called to check.
Poses poses(const py::handle& value, std::string_view what);

Doubles to_array(const Vec3& v);
Doubles to_array(const Pose& pose);              ///< (4, 4)
Doubles to_array(std::span<const Pose> poses);   ///< (n, 4, 4)
Doubles to_array(std::span<const Vec3> points);  ///< (n, 3)
py::array_t<std::uint32_t> to_array(std::span<const std::array<std::uint32_t, 3>> triangles);
py::array_t<std::uint32_t> to_array(std::span<const std::array<std::uint32_t, 2>> pairs);

}  // namespace tandem::python
