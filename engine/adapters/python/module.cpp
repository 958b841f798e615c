#include "bindings.h"
#include "tandem/version.h"

PYBIND11_MODULE(_tandem, module) {
  module.attr("__version__") = TANDEM_VERSION;
  tandem::python::bind_shapes(module);
  tandem::python::bind_pairs(module);
  tandem::python::bind_scene(module);
  tandem::python::bind_pipeline(module);
  tandem::python::bind_motion(module);
  tandem::python::bind_queries(module);
}
