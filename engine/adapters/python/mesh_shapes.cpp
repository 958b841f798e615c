// Bindings that make meshes: from arrays, files and sensor data, and solids from meshes that are not closed.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/parallel_for.h>

#include "arrays.h"
#include "bindings.h"
#include "building.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/narrowphase/shape_makers.h"
#include "tandem/narrowphase/winding_number.h"

namespace tandem::python {
namespace {

Mesh mesh_of(const py::object& vertices, const py::object& triangles, bool solid = false) {
  return {points(vertices, "vertices"), index_rows<std::uint32_t, 3>(triangles, "triangles"), solid};
}

Shape mesh(const py::object& vertices, const py::object& triangles, bool solid, const py::object& progress,
           std::optional<double> timeout) {
  Mesh given = mesh_of(vertices, triangles, solid);
  const Building building(progress, timeout);
  const py::gil_scoped_release released;
  return Shape(std::move(given), building.options());
}

Shape read_mesh(const std::filesystem::path& path, bool solid, const py::object& progress,
                std::optional<double> timeout) {
  const Building building(progress, timeout);
  const py::gil_scoped_release released;
  return read_mesh_shape(path, solid, building.options());
}

Shape point_cloud_of(const py::object& given, double radius) {
  const std::vector<Vec3> places = points(given, "points");
  const py::gil_scoped_release released;
  return point_cloud(places, radius);
}

Shape height_field_of(const py::handle& heights, double spacing, double bottom) {
  const Doubles h = doubles(heights, "heights", {-1, -1});
  const std::span<const double> numbers(h.data(), static_cast<std::size_t>(h.size()));
  const auto rows = static_cast<std::size_t>(h.shape(0)), columns = static_cast<std::size_t>(h.shape(1));
  const py::gil_scoped_release released;
  return height_field(numbers, columns, rows, spacing, bottom);
}

Shape voxels_of(const py::object& given, double size) {
  const auto cells = index_rows<std::int32_t, 3>(given, "cells");
  const py::gil_scoped_release released;
  return voxels(cells, size);
}

Shape solid_of(const py::object& vertices, const py::object& triangles, double size, double least,
               std::size_t most_cells, std::optional<double> timeout) {
  const Mesh given = mesh_of(vertices, triangles);
  const WorkLimit limit = limit_after(timeout);
  const py::gil_scoped_release released;
  return voxel_solid(given, {.size = size, .least = least, .most_cells = most_cells, .limit = &limit});
}

Doubles winding_numbers(const WindingNumber& winding, const py::object& given) {
  const std::vector<Vec3> places = points(given, "places");
  for (std::size_t i = 0; i < places.size(); ++i)
    if (!places[i].allFinite())
      throw std::invalid_argument("places[" + std::to_string(i) + "]: not finite, allowed: finite numbers");
  Doubles out(static_cast<py::ssize_t>(places.size()));
  double* numbers = out.mutable_data();
  const py::gil_scoped_release released;
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) { numbers[i] = winding.at(places[i]); });
  return out;
}

}  // namespace

void bind_mesh_shapes(py::module_& m) {
  const auto vertices = py::arg("vertices"), triangles = py::arg("triangles");
  const auto solid = py::arg("solid") = false, progress = py::arg("progress") = py::none(),
             timeout = py::arg("timeout") = py::none();
  m.def(
      "Mesh", &mesh, vertices, triangles, solid, py::kw_only(), progress, timeout,
      "vertices (n, 3), m; triangles (k, 3) indices. solid: the inside counts; each edge must then have as many\n"
      "triangles along it one way as the other.\n"
      "Made ready on all threads. progress: a function that is told how much is done, (0, 1], from any thread; what it "
      "raises\n"
      "ends the work. timeout: s; then TimeoutError.");
  m.def(
      "read_mesh", &read_mesh, py::arg("path"), solid, py::kw_only(), progress, timeout,
      "The mesh in a .obj, .stl, .ply, .off, .gltf or .glb file. solid: the inside counts. ValueError 'FILE:LINE: ...' "
      "where it\n"
      "cannot be used, or with the first edge that does not close. progress, timeout: of what comes after reading, as "
      "of "
      "Mesh.");
  m.def("point_cloud", &point_cloud_of, py::arg("points"), py::arg("radius"),
        "Balls of one radius (m, >= 0) about (n, 3) points, as one shape.");
  m.def("height_field", &height_field_of, py::arg("heights"), py::arg("spacing"), py::arg("bottom"),
        "The solid between `bottom` and (rows, columns) heights, m, `spacing` (m, > 0) apart; centred in x and y.");
  m.def("voxels", &voxels_of, py::arg("cells"), py::arg("size"),
        "The solid union of cubes of a grid. cells: (n, 3) whole numbers i, j, k, of the cube from (i, j, k) * size to "
        "(i + "
        "1, ...) *\n"
        "size, -2^20 to 2^20 - 2, in any order, doubles allowed. size: m, > 0.");
  m.def("voxel_solid", &solid_of, vertices, triangles, py::arg("size"), py::kw_only(),
        py::arg("least") = VoxelSolidOptions{}.least, py::arg("most_cells") = VoxelSolidOptions{}.most_cells, timeout,
        "A solid for a mesh that need not be closed: the cubes, of size (m, > 0), whose middles have at least that "
        "winding "
        "number.\n"
        "most_cells: of the mesh's box; more are refused. timeout: s; then TimeoutError.");
  py::class_<WindingNumber>(m, "WindingNumber",
                            "How often a mesh's surface goes round a place: 1 inside, 0 outside, between where it has "
                            "holes.")
      .def(py::init([](const py::object& v, const py::object& t) {
             const Mesh given = mesh_of(v, t);
             const py::gil_scoped_release released;
             return WindingNumber(given);
           }),
           vertices, triangles)
      .def("at", &winding_numbers, py::arg("places"), "(n,) of (n, 3) places in the mesh's frame, m; on all threads.");
}

}  // namespace tandem::python
