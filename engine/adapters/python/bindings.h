#pragma once
#include <pybind11/pybind11.h>

namespace tandem::python {

// Each adds its names to the module; in this order, as signatures name classes of those before.
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
