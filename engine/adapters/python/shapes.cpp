#include <pybind11/pybind11.h>
#include <pybind11/stl/filesystem.h>

#include <sstream>

#include "arrays.h"
#include "bindings.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/shape_makers.h"

namespace tandem::python {
namespace {

std::string described(const Shape& shape) {
  std::ostringstream out;
  out << "<tandem.Shape " << name(shape.kind()) << ", size " << shape.size() << " m>";
  return out.str();
}

Shape mesh(std::vector<Vec3> vertices, std::vector<std::array<std::uint32_t, 3>> triangles, bool solid) {
  const py::gil_scoped_release released;
  return Shape(Mesh{std::move(vertices), std::move(triangles), solid});
}

Shape read_mesh(const std::filesystem::path& path, bool solid) {
  const py::gil_scoped_release released;
  return read_mesh_shape(path, solid);
}

Shape height_field_of(const py::handle& heights, double spacing, double bottom) {
  const Doubles h = doubles(heights, "heights", {-1, -1});
  return height_field({h.data(), static_cast<std::size_t>(h.size())}, static_cast<std::size_t>(h.shape(1)),
                      static_cast<std::size_t>(h.shape(0)), spacing, bottom);
}

Shape voxels_of(const py::object& cells, double size) {
  std::vector<std::array<std::int32_t, 3>> places;
  for (const Vec3& cell : points(cells, "cells")) {
    if (cell != cell.array().round().matrix() || cell.cwiseAbs().maxCoeff() > (1 << 21))
      throw std::invalid_argument("cells: a number is not whole, or beyond 2^21");
    places.push_back(
        {static_cast<std::int32_t>(cell[0]), static_cast<std::int32_t>(cell[1]), static_cast<std::int32_t>(cell[2])});
  }
  return voxels(places, size);
}

void bind_shape_class(py::module_& module) {
  py::class_<Shape>(module, "Shape",
                    "A checked shape in its own frame, metres; immutable. Made by Sphere, Box, Mesh ...")
      .def("rounded", &Shape::rounded, py::arg("radius"),
           "This shape with a ball of the radius (m, >= 0) about each point.")
      .def_property_readonly(
          "kind", [](const Shape& s) { return std::string(name(s.kind())); }, "'sphere', 'box', ... 'mesh'")
      .def_property_readonly("size", &Shape::size, "Diagonal of the box in the shape's frame, m; of a half-space 0.")
      .def_property_readonly("rounding", &Shape::rounding, "m")
      .def_property_readonly("is_solid", &Shape::is_solid,
                             "Whether the inside counts: all but triangles and open meshes.")
      .def_property_readonly(
          "vertices", [](const Shape& s) { return to_array(s.vertices()); },
          "(n, 3), m: of a hull, triangle or mesh; else empty.")
      .def_property_readonly(
          "triangles", [](const Shape& s) { return to_array(s.triangles()); },
          "(n, 3) indices of vertices: of a triangle or mesh; else empty.")
      .def_property_readonly(
          "volume", [](const Shape& s) { return s.mass().volume; }, "m^3")
      .def_property_readonly(
          "centre_of_mass", [](const Shape& s) { return to_array(s.mass().centre); }, "(3,), m")
      .def_property_readonly("memory", &Shape::memory, "Bytes beside the object itself; copies share them.")
      .def(
          "bounds",
          [](const Shape& s, const py::object& at) {
            const Bounds b = s.bounds(pose(at, "pose"));
            return to_array(std::array{b.lo, b.hi});
          },
          py::arg("pose") = py::none(), "(2, 3): least and largest corner of the smallest box around it, world axes.")
      .def("__repr__", &described);
}

void bind_primitives(py::module_& m) {
  m.def(
      "Sphere", [](double radius) { return Shape(Sphere{radius}); }, py::arg("radius"), "radius >= 0, m; 0 is a point");
  m.def(
      "Box", [](const py::object& size) { return Shape(Box{vec3(size, "size")}); }, py::arg("size"),
      "size: (3,) full edge lengths, m, > 0; centred");
  m.def(
      "Capsule",
      [](double radius, double length) {
        return Shape(Capsule{radius, length});
      },
      py::arg("radius"), py::arg("length"), "radius > 0; a core segment of length >= 0 along z, centred; m");
  m.def(
      "Cylinder",
      [](double radius, double length) {
        return Shape(Cylinder{radius, length});
      },
      py::arg("radius"), py::arg("length"), "radius > 0; length > 0 along z, centred; m");
  m.def(
      "Cone",
      [](double radius, double length) {
        return Shape(Cone{radius, length});
      },
      py::arg("radius"), py::arg("length"), "base at z = -length / 2, apex at z = +length / 2; m");
  m.def(
      "Ellipsoid", [](const py::object& radii) { return Shape(Ellipsoid{vec3(radii, "radii")}); }, py::arg("radii"),
      "radii: (3,), m, > 0");
}

void bind_vertex_shapes(py::module_& m) {
  m.def(
      "HalfSpace",
      [](const py::object& normal, double offset) {
        return Shape(HalfSpace{vec3(normal, "normal"), offset});
      },
      py::arg("normal"), py::arg("offset") = 0.0, "normal . x <= offset; a normal of any length but 0");
  m.def(
      "Plane",
      [](const py::object& normal, double offset) {
        return Shape(Plane{vec3(normal, "normal"), offset});
      },
      py::arg("normal"), py::arg("offset") = 0.0, "normal . x = offset, two-sided; a normal of any length but 0");
  m.def(
      "Convex", [](const py::object& v) { return Shape(Convex{points(v, "vertices")}); }, py::arg("vertices"),
      "The hull of (n, 3) points, m; may be flat.");
  m.def(
      "Triangle",
      [](const py::object& value) {
        const Doubles v = doubles(value, "vertices", {3, 3});
        const double* x = v.data();
        return Shape(Triangle{{Vec3(x[0], x[1], x[2]), Vec3(x[3], x[4], x[5]), Vec3(x[6], x[7], x[8])}});
      },
      py::arg("vertices"), "vertices: (3, 3), m; may have no area");
  m.def(
      "Mesh",
      [](const py::object& v, const py::object& t, bool solid) {
        return mesh(points(v, "vertices"), index_rows<3>(t, "triangles"), solid);
      },
      py::arg("vertices"), py::arg("triangles"), py::arg("solid") = false,
      "vertices (n, 3), m; triangles (k, 3) indices. solid: the inside counts; every edge must then join two "
      "triangles.");
  m.def(
      "read_mesh", &read_mesh, py::arg("path"), py::arg("solid") = false,
      "The mesh in a .obj, .stl, .ply, .off, .gltf or .glb file. solid: the inside counts. ValueError 'FILE:LINE: ...' "
      "where it cannot be used, or with the first edge that does not close.");
  m.def(
      "point_cloud", [](const py::object& p, double radius) { return point_cloud(points(p, "points"), radius); },
      py::arg("points"), py::arg("radius"), "Balls of one radius (m, >= 0) about (n, 3) points, as one shape.");
  m.def("height_field", &height_field_of, py::arg("heights"), py::arg("spacing"), py::arg("bottom"),
        "The solid between `bottom` and (rows, columns) heights, m, `spacing` (m, > 0) apart; centred in x and y.");
  m.def(
      "voxels", &voxels_of, py::arg("cells"), py::arg("size"),
      "The union of cubes of a grid: (n, 3) whole numbers, cell (i, j, k) from (i, j, k) * size (m, > 0) on; a solid.");
}

}  // namespace

void bind_shapes(py::module_& m) {
  bind_shape_class(m);
  bind_primitives(m);
  bind_vertex_shapes(m);
}

}  // namespace tandem::python
