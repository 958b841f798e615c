// Bindings of continuous motion, contact events and recordings.
#include <pybind11/pybind11.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "detector.h"
#include "formats/output_file.h"
#include "formats/record_file.h"
#include "rows.h"
#include "scene_objects.h"
#include "tandem/engine/contact_memory.h"
#include "tandem/engine/continuous_motion.h"
#include "tandem/engine/response.h"

namespace tandem::python {

// A row of the array; the members' names are the array's fields.
struct MotionStopRow {
  double t;
  IdNumber a, b;
  Triple point, normal;
};

namespace {

using SharedResponse = SharedUse<Response>;
using SharedEvents = SharedUse<ContactEvents>;

std::unique_ptr<SharedResponse> response(int substeps, double friction, double rolling_resistance, double contact_hertz,
                                         double contact_damping_ratio, double max_push_out, double max_speed,
                                         int threads) {
  ResponseOptions options;
  options.substeps = substeps;
  options.friction = friction;
  options.rolling_resistance = rolling_resistance;
  options.contact_hertz = contact_hertz;
  options.contact_damping_ratio = contact_damping_ratio;
  options.max_push_out = max_push_out;
  options.max_speed = max_speed;
  options.threads = threads;
  return std::make_unique<SharedResponse>(options);
}

ResponseReport respond(SharedResponse& response, SharedScene& scene, const SharedPipeline& pipeline) {
  return response.change([&](Response& r) {
    return pipeline.read(
        [&](const Detector& d) { return scene.change([&](Scene& s) { return r.step(s, d.pipeline.contacts()); }); });
  });
}

// Ids as an array (n, 2).
py::array_t<IdNumber> ids_of(const std::vector<BodyPair>& pairs) {
  py::array_t<IdNumber> out({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}});
  IdNumber* id = out.mutable_data();
  for (const BodyPair& pair : pairs) {
    *id++ = number(pair.a);
    *id++ = number(pair.b);
  }
  return out;
}

template <std::span<const BodyPair> (ContactEvents::*Get)() const>
py::array_t<IdNumber> events_of(const SharedEvents& events) {
  return ids_of(
      events.read([](const ContactEvents& e) { return std::vector<BodyPair>((e.*Get)().begin(), (e.*Get)().end()); }));
}

/// A recording being written, of steps as a pipeline saw them.
class Recording {
 public:
  Recording(const std::filesystem::path& path, const Scene& scene) : file_("Recording", path), writer_(file_, scene) {}
  void add(const Scene& scene, const ContactList& contacts) {
    require_open();
    writer_.step(steps_++, hash(contacts), scene, contacts);
  }
  void close() {
    require_open();
    open_ = false;
    file_.commit();
  }

 private:
  void require_open() const {
    if (!open_) throw std::invalid_argument("Recording: it is closed, allowed: one that is open");
  }
  OutputFile file_;
  RecordWriter writer_;
  std::uint64_t steps_ = 0;
  bool open_ = true;
};
using SharedRecording = SharedUse<std::optional<Recording>>;

void bind_recording(py::module_& m) {
  py::class_<SharedRecording>(
      m, "Recording", "Writes steps to a file, for tandem.show and `tandem-bench report`; as `with` block, or closed.")
      .def(py::init([](const std::filesystem::path& path, const SharedScene& scene) {
             auto made = std::make_unique<SharedRecording>();
             made->change([&](auto& r) { scene.read([&](const Scene& s) { r.emplace(path, s); }); });
             return made;
           }),
           py::arg("path"), py::arg("scene"))
      .def(
          "add",
          [](SharedRecording& recording, const SharedScene& scene, const SharedPipeline& pipeline) {
            recording.change([&](auto& r) {
              pipeline.read(
                  [&](const Detector& d) { scene.read([&](const Scene& s) { r->add(s, d.pipeline.contacts()); }); });
            });
          },
          py::arg("scene"), py::arg("pipeline"), "After a step, before the scene changes.")
      .def("close", [](SharedRecording& recording) { recording.change([](auto& r) { r->close(); }); })
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](SharedRecording& recording, const py::object& type, const py::object&, const py::object&) {
        if (type.is_none()) recording.change([](auto& r) { r->close(); });
      });
}

void bind_events(py::module_& m) {
  py::class_<SharedEvents>(
      m, "ContactEvents", "Which pairs began to touch, still touch and no longer touch: (n, 2) ids, sorted by indices.")
      .def(py::init([] { return std::make_unique<SharedEvents>(); }))
      .def(
          "update",
          [](SharedEvents& events, const SharedScene& scene, const SharedPipeline& pipeline) {
            events.change([&](ContactEvents& e) {
              pipeline.read(
                  [&](const Detector& d) { scene.read([&](const Scene& s) { e.update(s, d.pipeline.contacts()); }); });
            });
          },
          py::arg("scene"), py::arg("pipeline"), "After a step, before the scene changes.")
      .def(
          "end_all", [](SharedEvents& events) { events.change([](ContactEvents& e) { e.end_all(); }); },
          "All that touched end, as if a step had found no contact.")
      .def_property_readonly("touching", &events_of<&ContactEvents::touching>, "began and stayed")
      .def_property_readonly("began", &events_of<&ContactEvents::began>)
      .def_property_readonly("stayed", &events_of<&ContactEvents::stayed>)
      .def_property_readonly("ended", &events_of<&ContactEvents::ended>);
}

py::tuple limited(const SharedScene& scene, const py::object& given) {
  std::vector<Pose> ends = poses(given, "ends");
  std::vector<MotionStop> stops;
  scene.read([&](const Scene& s) {
    ContinuousMotion motion;
    const auto found = motion.limit(s, ends);
    stops.assign(found.begin(), found.end());
  });
  return py::make_tuple(
      to_array(ends), structured<MotionStopRow>(stops, [](const MotionStop& stop) {
        return MotionStopRow{stop.t, number(stop.a), number(stop.b), numbers(stop.point), numbers(stop.normal)};
      }));
}

Doubles ends_of(const SharedScene& scene) {
  std::vector<Pose> ends;
  scene.read([&](const Scene& s) { free_ends(s, ends); });
  return to_array(ends);
}

void bind_continuous_motion(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(MotionStopRow, t, a, b, point, normal);
  m.def("free_ends", &ends_of, py::arg("scene"),
        "(indices, 4, 4): where each body would be after scene.dt by its velocities alone.");
  m.def(
      "limit_motion", &limited, py::arg("scene"), py::arg("ends"),
      "Keeps continuous bodies from passing through others on their way to ends, (indices, 4, 4) or (indices, 7): "
      "(ends taken\n"
      "back as far as needed, stops). Stops are a structured array: t ([0, 1] of the step), a, b (ids), point, normal "
      "(unit, from\n"
      "a to b). For who moves bodies himself; a Response does it.");
}

}  // namespace

void bind_motion(py::module_& m) {
  py::class_<ResponseReport>(m, "ResponseReport")
      .def_readonly("kinetic_energy", &ResponseReport::kinetic_energy, "J, all moving bodies")
      .def_readonly("max_depth", &ResponseReport::max_depth, "m, as detected")
      .def_readonly("stops", &ResponseReport::stops, "of continuous bodies on their way")
      .def_readonly("ms", &ResponseReport::ms, "wall")
      .def_readonly("serial_ms", &ResponseReport::serial_ms, "of it, what threads cannot share");
  py::class_<SharedResponse>(m, "Response", "Moves the bodies of one scene by their contacts, gravity and friction.")
      .def(py::init(&response), py::kw_only(), py::arg("substeps") = 4, py::arg("friction") = 0.5,
           py::arg("rolling_resistance") = ResponseOptions{}.rolling_resistance, py::arg("contact_hertz") = 30.0,
           py::arg("contact_damping_ratio") = ResponseOptions{}.contact_damping_ratio,
           py::arg("max_push_out") = ResponseOptions{}.max_push_out, py::arg("max_speed") = ResponseOptions{}.max_speed,
           py::arg("threads") = 0,
           "substeps: [1, 64], more is stiffer. friction: Coulomb, >= 0. rolling_resistance: torque over normal force "
           "and "
           "radius,\n"
           ">= 0. contact_hertz, contact_damping_ratio: of a contact, > 0. max_push_out: m/s at which overlap is "
           "undone. "
           "max_speed:\n"
           "m/s, faster bodies are slowed to it. threads: in all, 0: the caller's. The motion does not depend on them.")
      .def("step", &respond, py::arg("scene"), py::arg("pipeline"),
           "Moves the scene by its dt, by the contacts of the pipeline's last step.");
  m.def(
      "recommended_margin",
      [](const SharedScene& scene) { return scene.read([](const Scene& s) { return recommended_margin(s); }); },
      py::arg("scene"), "m: for a pipeline whose contacts a response uses.");
  bind_continuous_motion(m);
  bind_recording(m);
  bind_events(m);
}

}  // namespace tandem::python
