// Bindings of shapes.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <sstream>

#include "arrays.h"
#include "bindings.h"
#include "names.h"
#include "tandem/narrowphase/prepare.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/shape_memory.h"

namespace tandem::python {
namespace {

std::string described(const Shape& shape) {
  std::ostringstream out;
  out << "<tandem.Shape " << name(shape.kind()) << ", size " << shape.size() << " m>";
  return out.str();
}

py::dict parts_of(const ShapeMemory& m) {
  return by_part({{"surface", m.surface},
                  {"adjacency", m.adjacency},
                  {"hierarchy", m.hierarchy},
                  {"hull", m.hull},
                  {"other", m.other}});
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
          "cells",
          [](const Shape& s) {
            const auto cells = s.cells();
            py::array_t<std::int32_t> rows({static_cast<py::ssize_t>(cells.size()), py::ssize_t{4}});
            std::int32_t* to = rows.mutable_data();
            for (const auto& [corner, level] : cells) {
              to = std::copy(corner.begin(), corner.end(), to);
              *to++ = level;
            }
            return rows;
          },
          "(n, 4) i, j, k, level: of voxels, in the order by which contacts name them; else empty.")
      .def_property_readonly(
          "volume", [](const Shape& s) { return s.mass().volume; }, "m^3")
      .def_property_readonly(
          "centre_of_mass", [](const Shape& s) { return to_array(s.mass().centre); }, "(3,), m")
      .def_property_readonly(
          "inertia", [](const Shape& s) { return to_array(s.mass().inertia); },
          "(3, 3), m^5, about the centre of mass: times the density kg m^2")
      .def_property_readonly(
          "parameters", [](const Shape& s) { return to_array(s.parameters()); },
          "(4,), then zeros: radius; half a box's size; radius, length; radii; a half-space's or plane's normal, "
          "offset;\n"
          "of voxels the origin and the size of a cell. Of the core of a rounded shape.")
      .def_property_readonly("is_convex", &Shape::is_convex)
      .def_property_readonly("is_bounded", &Shape::is_bounded, "All but half-spaces and planes.")
      .def_property_readonly("memory", &Shape::memory, "Bytes beside the object itself; copies share them.")
      .def_property_readonly(
          "memory_by_part", [](const Shape& s) { return parts_of(s.memory_by_part()); },
          "The same by parts: surface, adjacency, hierarchy, hull, other.")
      .def(
          "bounds",
          [](const Shape& s, const py::object& at) {
            const Bounds b = s.bounds(pose(at, "pose"));
            return to_array(std::array{b.lo, b.hi});
          },
          py::arg("pose") = py::none(), "(2, 3): least and largest corner of the smallest box around it, world axes.")
      .def(
          "prepare", [](const Shape& s) { prepare(s); }, py::call_guard<py::gil_scoped_release>(),
          "Makes now what queries of a mesh make when they first need it, such as its hull.")
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
}

}  // namespace

void bind_shapes(py::module_& m) {
  bind_shape_class(m);
  bind_primitives(m);
  bind_vertex_shapes(m);
  m.def(
      "memory_of", [](const std::vector<Shape>& shapes) { return memory_of(shapes); }, py::arg("shapes"),
      "Bytes held beside these shapes; what several of them share, as copies do and a shape and its rounded one, "
      "once.");
}

}  // namespace tandem::python
