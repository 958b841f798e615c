// The Python module: all bindings.
#include <stdexcept>

#include "bindings.h"
#include "formats/input_error.h"
#include "formats/input_limits.h"
#include "tandem/narrowphase/work_limit.h"
#include "tandem/version.h"
#include "type_errors.h"

PYBIND11_MODULE(_tandem, module) {
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const tandem::WorkStopped& stopped) {
      PyErr_SetString(PyExc_TimeoutError, stopped.what());
    } catch (const std::invalid_argument& refusal) {  // may quote a name or a type of any length
      using namespace tandem;
      PyErr_SetString(PyExc_ValueError, shortened(on_one_line(refusal.what()), limits::message_bytes).c_str());
    }
  });
  module.attr("__version__") = TANDEM_VERSION;
  tandem::python::bind_shapes(module);
  tandem::python::bind_mesh_shapes(module);
  tandem::python::bind_boxes(module);
  tandem::python::bind_pairs(module);
  tandem::python::bind_meshes(module);
  tandem::python::bind_impacts(module);
  tandem::python::bind_scene(module);
  tandem::python::bind_pipeline(module);
  tandem::python::bind_motion(module);
  tandem::python::bind_queries(module);
  tandem::python::explain_type_errors(module);
}
