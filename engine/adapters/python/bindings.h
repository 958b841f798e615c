// The parts of the Python module.
#pragma once
#include <pybind11/pybind11.h>

namespace tandem::python {

// Each function adds its names to the module; in this order, since signatures name classes of earlier ones.
void bind_shapes(pybind11::module_& module);
void bind_mesh_shapes(pybind11::module_& module);
void bind_boxes(pybind11::module_& module);
void bind_pairs(pybind11::module_& module);
void bind_meshes(pybind11::module_& module);
void bind_impacts(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_pipeline(pybind11::module_& module);
void bind_motion(pybind11::module_& module);
void bind_queries(pybind11::module_& module);

}  // namespace tandem::python
