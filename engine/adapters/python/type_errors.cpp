// Type errors with one readable line.
#include "type_errors.h"

#include <string>
#include <string_view>

namespace tandem::python {

namespace py = pybind11;

namespace {

// pybind11's dispatcher, which all its functions share.
PyCFunctionWithKeywords dispatcher = nullptr;

// Replaces a TypeError about arguments by one with our line; other errors stay as they are.
void explain(PyObject* arguments, PyObject* named) {
  PyObject *type = nullptr, *value = nullptr, *trace = nullptr;
  PyErr_Fetch(&type, &value, &trace);
  PyErr_NormalizeException(&type, &value, &trace);
  const auto error = py::reinterpret_steal<py::object>(value);
  try {
    const std::string text = py::str(error);
    if (text.find("arguments. The following argument types are supported:") == std::string::npos) {
      PyErr_Restore(type, py::object(error).release().ptr(), trace);
      return;
    }
    const py::dict names = named != nullptr ? py::reinterpret_borrow<py::dict>(named) : py::dict();
    const py::object line =
        py::module_::import("tandem.type_errors").attr("explained")(text, py::handle(arguments), names);
    PyErr_SetObject(PyExc_TypeError, line.ptr());
  } catch (py::error_already_set&) {
    PyErr_Restore(type, py::object(error).release().ptr(), trace);
    return;
  }
  Py_XDECREF(type);
  Py_XDECREF(trace);
}

PyObject* call(PyObject* self, PyObject* arguments, PyObject* named) {
  PyObject* result = dispatcher(self, arguments, named);
  if (result == nullptr && PyErr_ExceptionMatches(PyExc_TypeError) != 0) explain(arguments, named);
  return result;
}

void explain_of(py::handle member) {
  if (PyObject_TypeCheck(member.ptr(), &PyProperty_Type) != 0) {
    explain_of(member.attr("fget"));
    explain_of(member.attr("fset"));
    return;
  }
  if (PyInstanceMethod_Check(member.ptr()) != 0) member = PyInstanceMethod_GET_FUNCTION(member.ptr());
  if (PyCFunction_Check(member.ptr()) == 0) return;
  PyMethodDef* definition = reinterpret_cast<PyCFunctionObject*>(member.ptr())->m_ml;
  constexpr int flags = METH_VARARGS | METH_KEYWORDS;  // other versions of pybind11 may use other flags
  if ((definition->ml_flags & flags) != flags || (definition->ml_flags & METH_FASTCALL) != 0) return;
  const auto its = reinterpret_cast<PyCFunctionWithKeywords>(reinterpret_cast<void (*)()>(definition->ml_meth));
  if (dispatcher == nullptr) dispatcher = its;
  if (its == dispatcher) definition->ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&call));
}

}  // namespace

void explain_type_errors(const py::module_& module) {
  for (const auto& [name, member] : py::reinterpret_borrow<py::dict>(module.attr("__dict__"))) {
    explain_of(member);
    if (PyType_Check(member.ptr()) == 0) continue;
    const py::dict members(member.attr("__dict__").attr("copy")());
    for (const auto& [its_name, its_member] : members) explain_of(its_member);
  }
}

}  // namespace tandem::python
