// Conversions between numpy arrays and vectors, poses and indices.
#include "arrays.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

#include "scene/tolerances.h"
#include "shared_use.h"

namespace tandem::python {
namespace {

constexpr std::size_t matrices_ahead = 16;  // number of matrices that are prefetched ahead

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return text + ")";
}

std::string shape_text(std::initializer_list<py::ssize_t> shape) {
  std::string text = "(";
  for (const py::ssize_t length : shape)
    text += (text.size() > 1 ? ", " : "") + (length < 0 ? "n" : std::to_string(length));
  return text + ")";
}

[[noreturn]] void refuse(std::string_view what, const std::string& found, const std::string& allowed) {
  throw std::invalid_argument(std::string(what) + ": " + found + ", allowed: " + allowed);
}

py::array any_array(const py::handle& value, std::string_view what) {
  py::array array = py::array::ensure(value);
  if (!array) {
    PyErr_Clear();
    refuse(what, "not an array", "real numbers");
  }
  return array;
}

std::string element(std::string_view what, std::size_t i) { return std::string(what) + "[" + std::to_string(i) + "]"; }

// True if a homogeneous matrix, 16 numbers row by row, has the last row 0 0 0 1.
bool has_last_row(const double* m) { return m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1; }

using Two [[gnu::vector_size(16)]] = double;
Two load(const double* from) {
  Two two;
  std::memcpy(&two, from, sizeof two);
  return two;
}
void store(Two two, double* to) { std::memcpy(to, &two, sizeof two); }

// Transposes rows to columns, two numbers at a time: a batch has matrices by the hundred thousand.
void read_matrix(const double* m, Pose& pose) {
  const Two x = load(m), y = load(m + 4), z = load(m + 8);
  double* columns = pose.rotation.data();
  store(__builtin_shufflevector(x, y, 0, 2), columns);
  store(__builtin_shufflevector(z, x, 0, 3), columns + 2);
  store(__builtin_shufflevector(y, z, 1, 3), columns + 4);
  columns[6] = m[2], columns[7] = m[6], columns[8] = m[10];
  pose.translation = {m[3], m[7], m[11]};
}

void require_last_row(const double* m, std::string_view what) {
  if (!has_last_row(m))
    refuse(what, "the last row of a (4, 4) matrix is not 0, 0, 0, 1", "a rotation and a translation");
}

// The quaternion of seven numbers: a translation, then w, x, y, z.
Quat quaternion(const double* v) { return {v[3], v[4], v[5], v[6]}; }

bool has_unit_quaternion(const double* v) { return std::abs(quaternion(v).norm() - 1) <= tolerance::quaternion_norm; }

void read_seven(const double* v, Pose& pose) { pose = Pose::from(quaternion(v), {v[0], v[1], v[2]}); }

void require_unit_quaternion(const double* v, std::string_view what) {
  if (!has_unit_quaternion(v))
    refuse(what, "a quaternion (w, x, y, z) of length " + written(quaternion(v).norm()), "length 1");
}

// Reads seven numbers of a list or tuple without making an array, which takes numpy a microsecond. False for anything
// else.
bool seven_numbers(const py::handle& value, std::array<double, 7>& out) {
  if (PyList_CheckExact(value.ptr()) == 0 && PyTuple_CheckExact(value.ptr()) == 0) return false;
  if (PySequence_Fast_GET_SIZE(value.ptr()) != 7) return false;
  PyObject* const* items = PySequence_Fast_ITEMS(value.ptr());
  for (std::size_t i = 0; i < 7; ++i) {
    if (PyFloat_CheckExact(items[i]) != 0) {
      out[i] = PyFloat_AS_DOUBLE(items[i]);
    } else if (PyLong_CheckExact(items[i]) != 0) {
      out[i] = PyLong_AsDouble(items[i]);
      if (PyErr_Occurred() != nullptr) {
        PyErr_Clear();
        return false;
      }
    } else {
      return false;
    }
  }
  return true;
}

Pose of_seven(const double* v, std::string_view what) {
  require_unit_quaternion(v, what);
  Pose pose;
  read_seven(v, pose);
  require_valid(pose, what);
  return pose;
}

void write(const Pose& pose, double* m) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[4 * i + j] = pose.rotation(i, j);
    m[4 * i + 3] = pose.translation[i];
    m[12 + i] = 0;
  }
  m[15] = 1;
}

template <std::size_t N>
py::array_t<std::uint32_t> rows(std::span<const std::array<std::uint32_t, N>> values) {
  py::array_t<std::uint32_t> out({static_cast<py::ssize_t>(values.size()), static_cast<py::ssize_t>(N)});
  if (!values.empty()) std::memcpy(out.mutable_data(), values.data(), values.size_bytes());
  return out;
}

}  // namespace

std::string written(double x) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, x).ptr};
}

Doubles doubles(const py::handle& value, std::string_view what) {
  if (py::isinstance<Doubles>(value)) return py::reinterpret_borrow<Doubles>(value);
  const py::array array = any_array(value, what);
  if (std::string_view("fiu").find(array.dtype().kind()) == std::string_view::npos)
    refuse(what, "an array of " + std::string(py::str(static_cast<const py::object&>(array.dtype()))), "real numbers");
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

Doubles doubles(const py::handle& value, std::string_view what, std::initializer_list<py::ssize_t> shape) {
  Doubles out = doubles(value, what);
  bool fits = out.ndim() == static_cast<py::ssize_t>(shape.size());
  for (std::size_t i = 0; fits && i < shape.size(); ++i) {
    const py::ssize_t length = shape.begin()[i];
    fits = length < 0 || out.shape(static_cast<py::ssize_t>(i)) == length;
  }
  if (!fits) refuse(what, "an array of shape " + shape_text(out), shape_text(shape));
  return out;
}

Vec3 vec3(const py::handle& value, std::string_view what) {
  const Doubles v = doubles(value, what, {3});
  return {v.data()[0], v.data()[1], v.data()[2]};
}

std::vector<Vec3> points(const py::handle& value, std::string_view what) {
  const Doubles v = doubles(value, what, {-1, 3});
  std::vector<Vec3> out(static_cast<std::size_t>(v.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = Eigen::Map<const Vec3>(v.data() + 3 * i);
  return out;
}

template <class Index, std::size_t N>
std::vector<std::array<Index, N>> index_rows(const py::handle& value, std::string_view what) {
  using Range = std::numeric_limits<Index>;
  const py::array array = any_array(value, what);
  if (array.dtype().kind() != 'i' && array.dtype().kind() != 'u') refuse(what, "not whole numbers", "whole numbers");
  constexpr auto columns = static_cast<py::ssize_t>(N);
  if (array.ndim() != 2 || array.shape(1) != columns)
    refuse(what, "an array of shape " + shape_text(array), shape_text({-1, columns}));
  const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
  // Numbers from 2^63 on became negative.
  const bool is_unsigned = array.dtype().kind() == 'u';
  std::vector<std::array<Index, N>> out(static_cast<std::size_t>(wide.shape(0)));
  for (std::size_t i = 0; i < N * out.size(); ++i) {
    const std::int64_t index = wide.data()[i];
    const bool wrapped = is_unsigned && index < 0;
    if (wrapped || index < Range::min() || index > Range::max())
      refuse(what,
             (wrapped ? std::to_string(static_cast<std::uint64_t>(index)) : std::to_string(index)) + " in row " +
                 std::to_string(i / N),
             '[' + std::to_string(Range::min()) + ", " + std::to_string(Range::max()) + ']');
    out[i / N][i % N] = static_cast<Index>(index);
  }
  return out;
}
template std::vector<std::array<std::int32_t, 3>> index_rows(const py::handle&, std::string_view);
template std::vector<std::array<std::uint32_t, 3>> index_rows(const py::handle&, std::string_view);
template std::vector<std::array<std::uint32_t, 4>> index_rows(const py::handle&, std::string_view);
template std::vector<std::array<std::int32_t, 4>> index_rows(const py::handle&, std::string_view);

Pose pose(const py::handle& value, std::string_view what) {
  if (value.is_none()) return {};
  if (std::array<double, 7> numbers; seven_numbers(value, numbers)) return of_seven(numbers.data(), what);
  const Doubles v = doubles(value, what);
  const bool matrix = v.ndim() == 2 && v.shape(0) == 4 && v.shape(1) == 4;
  if (!matrix && !(v.ndim() == 1 && v.shape(0) == 7))
    refuse(what, "an array of shape " + shape_text(v), "(4, 4), or (7): translation, then quaternion w, x, y, z");
  if (!matrix) return of_seven(v.data(), what);
  require_last_row(v.data(), what);
  Pose pose;
  read_matrix(v.data(), pose);
  require_valid(pose, what);
  return pose;
}

PoseRows::PoseRows(const py::handle& value, std::string_view what)
    : array_(doubles(value, what)), numbers_(array_.data()), what_(what) {
  const py::ssize_t n = array_.ndim();
  matrices_ = n >= 3 && array_.shape(n - 2) == 4 && array_.shape(n - 1) == 4;
  if (!matrices_ && !(n >= 2 && array_.shape(n - 1) == 7))
    refuse(what, "an array of shape " + shape_text(array_),
           "(..., 4, 4), or (..., 7): translations, then quaternions w, x, y, z");
  size_ = static_cast<std::size_t>(array_.size()) / (matrices_ ? 16 : 7);
}

void PoseRows::read(std::size_t first, std::span<Pose> out) const {
  const double* from = numbers_ + first * (matrices_ ? 16 : 7);
  if (matrices_) {
    for (std::size_t i = 0; i < out.size(); ++i, from += 16) {
      if (out.size() - i > matrices_ahead) __builtin_prefetch(from + 16 * matrices_ahead);
      if (!has_last_row(from)) require_last_row(from, element(what_, first + i));
      read_matrix(from, out[i]);
    }
  } else {
    for (std::size_t i = 0; i < out.size(); ++i, from += 7) {
      if (!has_unit_quaternion(from)) require_unit_quaternion(from, element(what_, first + i));
      read_seven(from, out[i]);
    }
  }
}

std::vector<Pose> poses(const py::handle& value, std::string_view what) {
  const PoseRows rows(value, what);
  std::vector<Pose> out(rows.size());
  const WithoutGil released;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, out.size(), 256), [&](const auto& block) {
    rows.read(block.begin(), std::span(out).subspan(block.begin(), block.size()));
  });
  return out;
}

Doubles to_array(const Vec3& v) {
  Doubles out(3);
  std::copy_n(v.data(), 3, out.mutable_data());
  return out;
}

Doubles to_array(const Mat3& matrix) {
  Doubles out({3, 3});
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(out.mutable_data()) = matrix;
  return out;
}

Doubles to_array(const std::array<double, 4>& numbers) {
  Doubles out(4);
  std::copy(numbers.begin(), numbers.end(), out.mutable_data());
  return out;
}

Doubles to_array(const Pose& pose) {
  Doubles out({4, 4});
  write(pose, out.mutable_data());
  return out;
}

Doubles to_array(std::span<const Pose> poses) {
  Doubles out({static_cast<py::ssize_t>(poses.size()), py::ssize_t{4}, py::ssize_t{4}});
  for (std::size_t i = 0; i < poses.size(); ++i) write(poses[i], out.mutable_data() + 16 * i);
  return out;
}

Doubles to_array(std::span<const Vec3> points) {
  Doubles out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  if (!points.empty()) std::memcpy(out.mutable_data(), points.data(), points.size_bytes());
  return out;
}

py::array_t<std::uint32_t> to_array(std::span<const std::array<std::uint32_t, 3>> triangles) { return rows(triangles); }
py::array_t<std::uint32_t> to_array(std::span<const std::array<std::uint32_t, 2>> pairs) { return rows(pairs); }

}  // namespace tandem::python
