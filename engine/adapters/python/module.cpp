// The Python module: all bindings.
#include "bindings.h"
#include "tandem/narrowphase/work_limit.h"
#include "tandem/version.h"
#include "type_errors.h"

PYBIND11_MODULE(_tandem, module) {
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const tandem::WorkStopped& stopped) {
      PyErr_SetString(PyExc_TimeoutError, stopped.what());
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
