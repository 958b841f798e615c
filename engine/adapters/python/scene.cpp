// Bindings of the scene.
#include "tandem/engine/scene.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>

#include "arrays.h"
#include "bindings.h"
#include "names.h"
#include "scene/tolerances.h"
#include "scene_objects.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/formats/scene_file.h"

namespace tandem::python {

std::vector<BodyId> body_ids(const py::handle& value, std::string_view what) {
  const py::array array = py::array::ensure(value);
  if (!array || array.ndim() != 1 ||
      (array.size() > 0 && std::string_view("iu").find(array.dtype().kind()) == std::string_view::npos)) {
    PyErr_Clear();
    throw std::invalid_argument(std::string(what) +
                                ": not a list of ids, allowed: an array of shape (n) of whole numbers");
  }
  const auto numbers = py::array_t<IdNumber, py::array::c_style | py::array::forcecast>::ensure(array);
  std::vector<BodyId> ids(static_cast<std::size_t>(numbers.size()));
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = body_id(numbers.data()[i]);
  return ids;
}

py::array_t<IdNumber> to_array(std::span<const BodyId> ids) {
  py::array_t<IdNumber> out(static_cast<py::ssize_t>(ids.size()));
  for (std::size_t i = 0; i < ids.size(); ++i) out.mutable_data()[i] = number(ids[i]);
  return out;
}

Request request(std::string_view text) {
  return named(text, "request", std::array{Request::collide, Request::distance, Request::contacts});
}

namespace {

IdNumber id_number(const py::object& value, const char* what) {
  try {
    return value.cast<IdNumber>();
  } catch (const py::cast_error&) {
    throw std::invalid_argument(std::string(what) + ": " + std::string(py::str(value)) + ", allowed: an id, [0, 2^64)");
  }
}

// The common arguments of add_body and add_bodies. The shape: one of the scene, or a new one.
struct BodyArguments {
  BodyOptions options;
  std::optional<Shape> shape;
};

BodyArguments arguments(const py::object& shape, const py::object& velocity, const py::object& angular_velocity,
                        double density, bool is_static, bool is_sensor, bool continuous, std::uint32_t group,
                        std::uint32_t mask) {
  BodyArguments body;
  if (py::isinstance<Shape>(shape)) {
    body.shape = shape.cast<Shape>();
  } else if (py::isinstance<py::int_>(shape)) {
    body.options.shape = shape_id(id_number(shape, "shape"));
  } else {
    throw std::invalid_argument("shape: " + std::string(py::str(py::type::of(shape))) +
                                ", allowed: a Shape, or the id of one of the scene");
  }
  if (!velocity.is_none()) body.options.velocity = vec3(velocity, "velocity");
  if (!angular_velocity.is_none()) body.options.angular_velocity = vec3(angular_velocity, "angular_velocity");
  body.options.density = density;
  body.options.is_static = is_static;
  body.options.is_sensor = is_sensor;
  body.options.continuous = continuous;
  body.options.group = group;
  body.options.mask = mask;
  return body;
}

// Adds bodies; a new shape is added to the scene only if its bodies are.
std::vector<BodyId> add(Scene& scene, BodyArguments body, std::span<const Pose> poses) {
  if (body.shape) body.options.shape = scene.add_shape(*std::move(body.shape));
  std::vector<BodyId> ids;
  ids.reserve(poses.size());
  try {
    for (const Pose& pose : poses) {
      body.options.pose = pose;
      ids.push_back(scene.add_body(body.options));
    }
  } catch (...) {
    for (const BodyId id : ids) scene.remove_body(id);
    if (body.shape) scene.remove_shape(body.options.shape);
    throw;
  }
  return ids;
}

template <class... Rest>
IdNumber add_body(SharedScene& scene, const py::object& shape, const py::object& at, Rest... rest) {
  const BodyArguments body = arguments(shape, rest...);
  const Pose where = pose(at, "pose");
  return number(scene.change([&](Scene& s) { return add(s, body, {&where, 1}); }).front());
}

template <class... Rest>
py::array_t<IdNumber> add_bodies(SharedScene& scene, const py::object& shape, const py::object& at, Rest... rest) {
  const BodyArguments body = arguments(shape, rest...);
  const std::vector<Pose> where = poses(at, "poses");
  return to_array(scene.change([&](Scene& s) { return add(s, body, where); }));
}

// The ids by index; 0 for unused indices.
py::array_t<IdNumber> ids(const SharedScene& scene) {
  return to_array(scene.read([](const Scene& s) {
    std::vector<BodyId> all(s.indices());
    for (std::uint32_t i = 0; i < all.size(); ++i)
      if (s.alive(i)) all[i] = s.id(i);
    return all;
  }));
}

std::vector<Pose> poses_of(const Scene& scene) { return {scene.poses().begin(), scene.poses().end()}; }

// One of the scene's lists by index, as an array.
template <class Value, std::span<const Value> (Scene::*Get)() const>
py::array_t<Value> list_of(const SharedScene& scene) {
  const auto copy = scene.read([](const Scene& s) { return std::vector<Value>((s.*Get)().begin(), (s.*Get)().end()); });
  return py::array_t<Value>(static_cast<py::ssize_t>(copy.size()), copy.data());
}
template <std::span<const std::uint8_t> (Scene::*Get)() const>
py::array_t<bool> flags_of(const SharedScene& scene) {
  const py::object numbers = list_of<std::uint8_t, Get>(scene);
  return numbers.attr("astype")("bool");
}
template <std::span<const Vec3> (Scene::*Get)() const>
Doubles vectors_of(const SharedScene& scene) {
  return to_array(std::span<const Vec3>(
      scene.read([](const Scene& s) { return std::vector<Vec3>((s.*Get)().begin(), (s.*Get)().end()); })));
}

SceneMemory memory_of(const SharedScene& scene) {
  return scene.read([](const Scene& s) { return s.memory(); });
}

py::list builtin_names() {
  py::list names;
  for (const BuiltinScene& scene : builtin_scenes()) names.append(py::str(scene.name.data(), scene.name.size()));
  return names;
}

void bind_adding(py::class_<SharedScene>& scene) {
  const auto shape = py::arg("shape");
  const auto velocity = py::arg("velocity") = py::none(), spin = py::arg("angular_velocity") = py::none(),
             density = py::arg("density") = 1000.0, fixed = py::arg("is_static") = false,
             sensor = py::arg("is_sensor") = false, continuous = py::arg("continuous") = false,
             group = py::arg("group") = 1, mask = py::arg("mask") = 0xffffffffu;
  using Object = const py::object&;
  scene
      .def("add_body", &add_body<Object, Object, double, bool, bool, bool, std::uint32_t, std::uint32_t>, shape,
           py::arg("pose") = py::none(), py::kw_only(), velocity, spin, density, fixed, sensor, continuous, group, mask,
           "Adds a body; returns its id. shape: a Shape, or the id of one of the scene. velocity, angular_velocity: "
           "(3,), m/s\n"
           "and rad/s, of the centre of mass, world axes. density: kg/m^3, > 0. is_static: never moved by a response.\n"
           "is_sensor: reported, never pushed. continuous: passes through nothing, however fast it is. group, mask: "
           "bits; a\n"
           "pair needs both directions.")
      .def("add_bodies", &add_bodies<Object, Object, double, bool, bool, bool, std::uint32_t, std::uint32_t>, shape,
           py::arg("poses"), py::kw_only(), velocity, spin, density, fixed, sensor, continuous, group, mask,
           "The same for (n, 4, 4) or (n, 7) poses, all of one shape; returns (n,) ids. All or none are added.")
      .def(
          "remove_body", [](SharedScene& s, IdNumber id) { s.change([&](Scene& x) { x.remove_body(body_id(id)); }); },
          py::arg("id"));
}

void bind_changes(py::class_<SharedScene>& scene) {
  scene
      .def(
          "set_pose",
          [](SharedScene& s, IdNumber id, const py::object& at) {
            const Pose where = pose(at, "pose");
            s.change([&](Scene& x) { x.set_pose(body_id(id), where); });
          },
          py::arg("id"), py::arg("pose"))
      .def(
          "set_poses",
          [](SharedScene& s, const py::object& which, const py::object& at) {
            const std::vector<BodyId> bodies = body_ids(which, "ids");
            const std::vector<Pose> where = poses(at, "poses");
            s.change([&](Scene& x) { x.set_poses(bodies, where); });
          },
          py::arg("ids"), py::arg("poses"), "Of many bodies: (n,) ids and as many poses. All or none are changed.")
      .def(
          "set_velocity",
          [](SharedScene& s, IdNumber id, const py::object& velocity, const py::object& angular) {
            const Vec3 v = vec3(velocity, "velocity"), w = vec3(angular, "angular_velocity");
            s.change([&](Scene& x) { x.set_velocity(body_id(id), v, w); });
          },
          py::arg("id"), py::arg("velocity"), py::arg("angular_velocity"), "(3,) each: m/s, rad/s")
      .def(
          "set_shape",
          [](SharedScene& s, IdNumber id, IdNumber to) {
            s.change([&](Scene& x) { x.set_shape(body_id(id), shape_id(to)); });
          },
          py::arg("id"), py::arg("shape"), "shape: the id of one of the scene")
      .def(
          "replace_shape",
          [](SharedScene& s, IdNumber id, const Shape& shape) {
            s.change([&](Scene& x) { x.replace_shape(shape_id(id), shape); });
          },
          py::arg("id"), py::arg("shape"), "Gives all bodies of the shape with this id another one in its place.")
      .def(
          "set_filter",
          [](SharedScene& s, IdNumber id, std::uint32_t g, std::uint32_t m) {
            s.change([&](Scene& x) { x.set_filter(body_id(id), g, m); });
          },
          py::arg("id"), py::arg("group"), py::arg("mask"))
      .def(
          "set_static",
          [](SharedScene& s, IdNumber id, bool f) { s.change([&](Scene& x) { x.set_static(body_id(id), f); }); },
          py::arg("id"), py::arg("is_static"))
      .def(
          "set_continuous",
          [](SharedScene& s, IdNumber id, bool c) { s.change([&](Scene& x) { x.set_continuous(body_id(id), c); }); },
          py::arg("id"), py::arg("continuous"))
      .def(
          "set_density",
          [](SharedScene& s, IdNumber id, double d) { s.change([&](Scene& x) { x.set_density(body_id(id), d); }); },
          py::arg("id"), py::arg("density"), "kg/m^3, finite, > 0; not used of what is static.")
      .def(
          "set_sensor",
          [](SharedScene& s, IdNumber id, bool f) { s.change([&](Scene& x) { x.set_sensor(body_id(id), f); }); },
          py::arg("id"), py::arg("is_sensor"));
}

void bind_reading(py::class_<SharedScene>& scene) {
  scene
      .def(
          "pose",
          [](const SharedScene& s, IdNumber id) {
            return to_array(s.read([&](const Scene& x) { return x.pose(body_id(id)); }));
          },
          py::arg("id"), "(4, 4)")
      .def(
          "index",
          [](const SharedScene& s, IdNumber id) {
            return s.read([&](const Scene& x) { return static_cast<void>(x.pose(body_id(id))), body_id(id).index(); });
          },
          py::arg("id"), "As in contacts and pairs.")
      .def(
          "shape_of",
          [](const SharedScene& s, IdNumber id) {
            return s.read([&](const Scene& x) {
              return static_cast<void>(x.pose(body_id(id))), x.shape_of(body_id(id).index());
            });
          },
          py::arg("id"))
      .def(
          "shape_id",
          [](const SharedScene& s, IdNumber id) {
            return number(s.read([&](const Scene& x) { return x.shape_id(body_id(id)); }));
          },
          py::arg("id"), "Of a body's shape.")
      .def("ids", &ids,
           "(indices,) uint64: scene.ids()[contacts['a']] are the ids of bodies in contact; 0 where none lives.")
      .def(
          "poses", [](const SharedScene& s) { return to_array(std::span<const Pose>(s.read(&poses_of))); },
          "(indices, 4, 4); those of removed bodies are stale.")
      .def("__len__", [](const SharedScene& s) { return s.read([](const Scene& x) { return x.bodies(); }); });
}

void bind_lists(py::class_<SharedScene>& scene) {
  scene.def("velocities", &vectors_of<&Scene::velocities>, "(indices, 3), m/s, of the centres of mass, world axes.")
      .def("angular_velocities", &vectors_of<&Scene::angular_velocities>, "(indices, 3), rad/s, world axes.")
      .def("densities", &list_of<double, &Scene::densities>, "(indices,), kg/m^3.")
      .def("groups", &list_of<std::uint32_t, &Scene::groups>, "(indices,) bits.")
      .def("masks", &list_of<std::uint32_t, &Scene::masks>, "(indices,) bits.")
      .def("is_static", &flags_of<&Scene::is_static>, "(indices,) bool.")
      .def("is_sensor", &flags_of<&Scene::is_sensor>, "(indices,) bool.")
      .def("continuous", &flags_of<&Scene::continuous>, "(indices,) bool.");
}

void bind_settings(py::class_<SharedScene>& scene) {
  scene
      .def_property_readonly(
          "memory", [](const SharedScene& s) { return memory_of(s).total(); },
          "Bytes, shapes included; what several have in common once.")
      .def_property_readonly(
          "memory_by_part",
          [](const SharedScene& s) {
            const SceneMemory m = memory_of(s);
            return by_part({{"bodies", m.bodies}, {"shapes", m.shapes}, {"shape_names", m.shape_names}});
          },
          "The same by parts: bodies, shapes, shape_names.")
      .def_property(
          "name", [](const SharedScene& s) { return s.read([](const Scene& x) { return x.name; }); },
          [](SharedScene& s, std::string to) { s.change([&](Scene& x) { x.name = std::move(to); }); })
      .def_property(
          "gravity", [](const SharedScene& s) { return to_array(s.read([](const Scene& x) { return x.gravity; })); },
          [](SharedScene& s, const py::object& to) {
            const Vec3 v = vec3(to, "gravity");
            if (!v.allFinite()) throw std::invalid_argument("gravity: not finite, allowed: finite numbers, m/s^2");
            if (!(v.cwiseAbs().maxCoeff() <= tolerance::largest_of_response))
              throw std::invalid_argument("gravity: " + written(v.cwiseAbs().maxCoeff()) +
                                          ", allowed: at most 1e30 m/s^2 in size");
            s.change([&](Scene& x) { x.gravity = v; });
          },
          "(3,), m/s^2")
      .def_property(
          "dt", [](const SharedScene& s) { return s.read([](const Scene& x) { return x.dt; }); },
          [](SharedScene& s, double to) {
            if (!(to > 0 && to <= tolerance::longest_time_step))
              throw std::invalid_argument("dt: " + written(to) + ", allowed: " + tolerance::time_step_range);
            s.change([&](Scene& x) { x.dt = to; });
          },
          "s, of one step")
      .def("__repr__", [](const SharedScene& s) {
        return s.read([](const Scene& x) {
          return "<tandem.Scene '" + x.name + "', " + std::to_string(x.bodies()) + " bodies>";
        });
      });
}

}  // namespace

void bind_scene(py::module_& m) {
  py::class_<SharedScene> scene(
      m, "Scene",
      "Bodies and their shapes. Ids of bodies and shapes are whole numbers; that of a removed one is found out.");
  scene.def(py::init([] { return std::make_unique<SharedScene>(); }))
      .def("copy",
           [](const SharedScene& s) { return std::make_unique<SharedScene>(s.read([](const Scene& x) { return x; })); })
      .def(
          "add_shape",
          [](SharedScene& s, const Shape& shape, const std::string& name) {
            return number(s.change([&](Scene& x) { return x.add_shape(shape, name); }));
          },
          py::arg("shape"), py::arg("name") = "", "Returns its id: many bodies may have one shape.")
      .def(
          "remove_shape",
          [](SharedScene& s, IdNumber id) { s.change([&](Scene& x) { x.remove_shape(shape_id(id)); }); },
          py::arg("id"));
  bind_adding(scene);
  bind_changes(scene);
  bind_reading(scene);
  bind_lists(scene);
  bind_settings(scene);
  m.def("builtin_scenes", &builtin_names, "Names for builtin_scene.");
  m.def(
      "builtin_scene",
      [](const std::string& name, std::size_t bodies, std::uint64_t seed) {
        const py::gil_scoped_release released;
        return std::make_unique<SharedScene>(make_builtin_scene(name, bodies, seed));
      },
      py::arg("name"), py::arg("bodies") = 0, py::arg("seed") = 1, "bodies: 0 is the paper's size; [1, 1000000].");
  m.def(
      "read_scene",
      [](const std::filesystem::path& path) {
        const py::gil_scoped_release released;
        return std::make_unique<SharedScene>(read_scene_file(path));
      },
      py::arg("path"), "ValueError 'FILE: POINTER: ...' where it cannot be used.");
  m.def(
      "write_scene",
      [](const std::filesystem::path& path, const SharedScene& s) {
        s.read([&](const Scene& x) { write_scene_file(path, x); });
      },
      py::arg("path"), py::arg("scene"), "Read back, it has the same contacts, bit for bit.");
}

}  // namespace tandem::python
