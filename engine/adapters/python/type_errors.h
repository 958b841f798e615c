// One-line type errors of Python calls.
#pragma once
#include <pybind11/pybind11.h>

namespace tandem::python {

/// Makes calls of the module's functions and methods with arguments that do not fit raise a TypeError of one line, by
/// type_errors.explained of the package; pybind11's lists signatures and values over several lines. To be called after
/// all is bound.
void explain_type_errors(const pybind11::module_& module);

}  // namespace tandem::python
