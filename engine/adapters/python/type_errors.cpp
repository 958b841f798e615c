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

bool is_of_ours(PyObject* object) {
  return PyType_IsSubtype(Py_TYPE(Py_TYPE(object)), py::detail::get_internals().default_metaclass) != 0;
}

// Made by __new__ alone, without a value, or without that of one of several bases: pybind11 would call a method of
// none.
bool has_no_value(PyObject* object) {
  if (!is_of_ours(object)) return false;
  for (const auto& held : py::detail::values_and_holders(reinterpret_cast<py::detail::instance*>(object)))
    if (held.value_ptr() == nullptr) return true;
  return false;
}

// Sets a TypeError where it has no value.
bool is_refused(PyObject* object) {
  if (!has_no_value(object)) return false;
  const std::string_view path = Py_TYPE(object)->tp_name;
  const std::string name(path.substr(path.rfind('.') + 1));
  PyErr_Format(PyExc_TypeError, "%s: made by __new__ alone, expected: %s(...)", name.c_str(), name.c_str());
  return true;
}

// Sets a TypeError where it, or an item of a sequence that pybind11 may read as one of our classes, has no value.
bool is_any_refused(PyObject* object) {
  if (is_refused(object)) return true;
  if (PySequence_Check(object) == 0 || is_of_ours(object)) return false;
  if (PyUnicode_Check(object) != 0 || PyObject_CheckBuffer(object) != 0) return false;  // text, arrays
  const auto items = py::reinterpret_steal<py::object>(PySequence_Fast(object, ""));
  if (!items) PyErr_Clear();  // pybind11 tells what is wrong
  for (Py_ssize_t k = 0; items && k < PySequence_Fast_GET_SIZE(items.ptr()); ++k)
    if (is_refused(PySequence_Fast_GET_ITEM(items.ptr(), k))) return true;
  return false;
}

// Sets a TypeError where one of them, from the given one on, has no value.
bool refuse(PyObject* arguments, PyObject* named, Py_ssize_t first) {
  for (Py_ssize_t k = first; k < PyTuple_GET_SIZE(arguments); ++k)
    if (is_any_refused(PyTuple_GET_ITEM(arguments, k))) return true;
  PyObject *name = nullptr, *value = nullptr;
  for (Py_ssize_t at = 0; named != nullptr && PyDict_Next(named, &at, &name, &value) != 0;)
    if (is_any_refused(value)) return true;
  return false;
}

template <Py_ssize_t first>
PyObject* call(PyObject* self, PyObject* arguments, PyObject* named) {
  if (refuse(arguments, named, first)) return nullptr;
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
  if (its != dispatcher) return;
  // __init__ gives the first its value.
  const auto ours = std::string_view(definition->ml_name) == "__init__" ? &call<1> : &call<0>;
  definition->ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(ours));
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
