// Structured numpy arrays.
#pragma once
#include <pybind11/numpy.h>

#include <array>

#include "tandem/narrowphase/pose.h"

namespace tandem::python {

/// Points and vectors as fields of structured arrays. A row is a struct of such fields, described to numpy by
/// PYBIND11_NUMPY_DTYPE before an array of it is made.
using Triple = std::array<double, 3>;
inline Triple numbers(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// A structured array with a row for each element of the list, made by `row`.
template <class Row, class List, class MakeRow>
pybind11::array structured(const List& list, const MakeRow& row) {
  pybind11::array_t<Row> out(static_cast<pybind11::ssize_t>(list.size()));
  Row* to = out.mutable_data();
  for (const auto& element : list) *to++ = row(element);
  return out;
}

}  // namespace tandem::python
