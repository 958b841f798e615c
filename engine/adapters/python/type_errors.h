#pragma once
#include <pybind11/pybind11.h>

namespace tandem::python {

/// Calls of the module's functions and methods with arguments that do not fit raise a TypeError of one line, by
/// type_errors.explained of the package; pybind11's list signatures and values over several. Call it after all is
/// bound.
void explain_type_errors(const pybind11::module_& module);

}  // namespace tandem::python
