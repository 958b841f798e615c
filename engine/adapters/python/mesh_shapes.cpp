// Bindings that make meshes: from arrays, files and sensor data, and solids from meshes that are not closed.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <tbb/parallel_for.h>

#include "arrays.h"
#include "bindings.h"
#include "building.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/formats/octomap_file.h"
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

Shape voxels_of(const py::object& given, double size, const py::object& origin) {
  Voxels grid{.cells = {}, .cell_size = size, .origin = origin.is_none() ? Vec3(Vec3::Zero()) : vec3(origin, "origin")};
  const auto shape = py::array::ensure(given);
  if (shape && shape.ndim() == 2 && shape.shape(1) == 4) {
    const auto cells = index_rows<std::int32_t, 4>(given, "cells");
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i][3] < 0 || cells[i][3] > 20)
        throw std::invalid_argument("cells: level " + std::to_string(cells[i][3]) + " in row " + std::to_string(i) +
                                    ", allowed: 0 to 20");
      grid.cells.push_back({{cells[i][0], cells[i][1], cells[i][2]}, static_cast<std::uint8_t>(cells[i][3])});
    }
  } else {
    for (const auto& cell : index_rows<std::int32_t, 3>(given, "cells")) grid.cells.push_back({cell, 0});
  }
  const py::gil_scoped_release released;
  return Shape(grid);
}

Shape occupancy_grid_of(const py::object& given, double size, const py::object& origin) {
  const auto occupied = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(given);
  if (!occupied || occupied.ndim() != 3) throw std::invalid_argument("occupied: not (nz, ny, nx), as it must be");
  const std::span<const std::uint8_t> values(reinterpret_cast<const std::uint8_t*>(occupied.data()),
                                             static_cast<std::size_t>(occupied.size()));
  const auto count = [&](int k) { return static_cast<std::size_t>(occupied.shape(k)); };
  const Vec3 corner = origin.is_none() ? Vec3(Vec3::Zero()) : vec3(origin, "origin");
  const std::array<std::size_t, 3> counts{count(2), count(1), count(0)};
  const py::gil_scoped_release released;
  return occupancy_grid(values, counts, size, corner);
}

Shape voxel_mesh_of(const py::object& given, double size) {
  const auto cells = index_rows<std::int32_t, 3>(given, "cells");
  const py::gil_scoped_release released;
  return voxel_mesh(cells, size);
}

Shape octomap_of(const std::filesystem::path& path) {
  const py::gil_scoped_release released;
  const Voxels leaves = read_octomap_file(path);
  try {
    return Shape(leaves);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(path.string() + ": " + error.what());
  }
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

void bind_voxels(py::module_& m) {
  const auto origin = py::arg("origin") = py::none();
  m.def("voxels", &voxels_of, py::arg("cells"), py::arg("size"), origin,
        "The solid union of cubes of a grid, of kind 'voxels'. cells: (n, 3) whole numbers i, j, k, of the cube from "
        "origin +\n"
        "(i, j, k) * size to origin + (i + 1, ...) * size, -2^20 to 2^20 - 1, in any order, doubles allowed; or (n, 4) "
        "with a level l,\n"
        "0 to 20, of a cube 2^l times as wide whose i, j, k are multiples of that. size: m, > 0. origin: (3,), m.");
  m.def("occupancy_grid", &occupancy_grid_of, py::arg("occupied"), py::arg("size"), origin,
        "The same of a dense grid: (nz, ny, nx), what is not 0 is occupied; [0, 0, 0] is the cube that begins at "
        "origin.");
  m.def("voxel_mesh", &voxel_mesh_of, py::arg("cells"), py::arg("size"),
        "The surface of such cubes as a solid mesh: of the faces between a cell and a place without one. cells: (n, "
        "3), -2^20 to 2^20 - 2.");
  m.def("read_octomap", &octomap_of, py::arg("path"),
        "The occupied leaves of an octree in one of octomap's .bt or .ot files, as voxels. ValueError 'FILE: byte N: "
        "...' where it\n"
        "cannot be used, 'FILE: voxels: ...' where no leaf is occupied.");
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
  bind_voxels(m);
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
