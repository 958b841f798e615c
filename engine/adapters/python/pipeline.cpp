#include "tandem/engine/pipeline.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "bindings.h"
#include "contact_arrays.h"
#include "detector.h"
#include "formats/output_file.h"
#include "names.h"
#include "scene_objects.h"
#include "timeout.h"

namespace tandem::python {
namespace {

std::unique_ptr<SharedPipeline> pipeline(int threads, const std::string& executor, const std::string& broad_phase,
                                         const std::string& asked, double tolerance, double margin,
                                         double keep_contacts, bool mesh_margin, bool contact_hash,
                                         std::optional<std::array<int, 2>> split) {
  PipelineOptions options;
  options.threads = threads;
  options.executor = named(executor, "executor", executor_kinds);
  options.broad_phase = named(broad_phase, "broad_phase",
                              std::array{BroadPhaseKind::brute, BroadPhaseKind::sweep, BroadPhaseKind::grid,
                                         BroadPhaseKind::bvh, BroadPhaseKind::automatic});
  options.answer.request = request(asked);
  options.answer.tolerance = tolerance;
  options.answer.margin = margin;
  options.answer.keep_contacts = keep_contacts;
  options.answer.mesh_margin = mesh_margin;
  options.answer.contact_hash = contact_hash;
  if (split) options.balance.split = {(*split)[0], (*split)[1]};
  return std::make_unique<SharedPipeline>(std::move(options));
}

StepReport step(SharedPipeline& pipeline, const SharedScene& scene, std::optional<double> timeout) {
  const auto deadline = deadline_after(timeout);
  return pipeline.change(
      [&](Detector& d) { return scene.look([&](const Scene& s) { return d.pipeline.step(s, {}, deadline); }); });
}

// The list is copied while no step may run, as making an array takes the GIL.
ContactList list_of(const SharedPipeline& pipeline) {
  return pipeline.look([](const Detector& d) { return d.pipeline.contacts(); });
}

void record_timeline(SharedPipeline& pipeline) {
  pipeline.change([](Detector& d) {
    auto fresh = std::make_unique<Timeline>();
    d.pipeline.record_to(fresh.get());
    d.timeline = std::move(fresh);
  });
}

void write_timeline(SharedPipeline& pipeline, const std::filesystem::path& path) {
  pipeline.change([&](Detector& d) {
    if (!d.timeline)
      throw std::invalid_argument("write_timeline: nothing was recorded, allowed: after record_timeline");
    OutputFile file("write_timeline", path);
    d.timeline->write(file.stream());
    file.commit();
    d.pipeline.record_to(nullptr);
    d.timeline.reset();
  });
}

std::vector<std::string> issues(const StepReport& report) {
  std::vector<std::string> out;
  const auto add = [&](StepIssue issue, const char* text) {
    if ((report.execution.issues & bit(issue)) != 0) out.emplace_back(text);
  };
  add(StepIssue::inexact, "inexact");
  add(StepIssue::pool_grew, "pool_grew");
  add(StepIssue::ran_on_caller, "ran_on_caller");
  add(StepIssue::ended_early, "ended_early");
  add(StepIssue::incomplete, "incomplete");
  return out;
}

void bind_report(py::module_& m) {
  const auto of_execution = [](auto member) { return [member](const StepReport& r) { return r.execution.*member; }; };
  py::class_<StepReport>(m, "StepReport", "What one step found and did; times in ms.")
      .def_readonly("step", &StepReport::step)
      .def_readonly("bodies", &StepReport::bodies)
      .def_readonly("colliding_pairs", &StepReport::colliding_pairs)
      .def_readonly("contacts", &StepReport::contacts, "that touch or overlap")
      .def_readonly("gaps", &StepReport::gaps, "contacts within the margin")
      .def_readonly("contact_hash", &StepReport::contact_hash, "0 unless asked for")
      .def_readonly("max_depth", &StepReport::max_depth, "m")
      .def_readonly("kept_pairs", &StepReport::kept_pairs)
      .def_readonly("computed_pairs", &StepReport::computed_pairs)
      .def_readonly("kept_error_bound", &StepReport::kept_error_bound, "m")
      .def_property_readonly("broad_phase", [](const StepReport& r) { return std::string(name(r.broad_phase)); })
      .def_property_readonly("candidate_pairs", of_execution(&ExecutionReport::candidate_pairs))
      .def_property_readonly("detect_ms", of_execution(&ExecutionReport::detect_ms), "wall")
      .def_property_readonly("broad_ms", of_execution(&ExecutionReport::broad_ms), "busy, summed over threads")
      .def_property_readonly("narrow_ms", of_execution(&ExecutionReport::narrow_ms), "busy, summed over threads")
      .def_property_readonly("threads", of_execution(&ExecutionReport::threads))
      .def_property_readonly(
          "split",
          [](const StepReport& r) { return py::make_tuple(r.execution.split.broad, r.execution.split.narrow); })
      .def_property_readonly("form", [](const StepReport& r) { return std::string(name(r.execution.form)); })
      .def_property_readonly("issues", &issues, "'inexact', 'pool_grew', 'ran_on_caller', 'ended_early', 'incomplete'")
      .def("__repr__", [](const StepReport& r) {
        return "<tandem.StepReport " + std::to_string(r.step) + ": " + std::to_string(r.contacts) + " contacts of " +
               std::to_string(r.bodies) + " bodies>";
      });
}

}  // namespace

void bind_pipeline(py::module_& m) {
  bind_report(m);
  py::class_<SharedPipeline>(
      m, "Pipeline", "Detects collisions in a scene, step by step; the answer does not depend on threads or executor.")
      .def(py::init(&pipeline), py::kw_only(), py::arg("threads") = 0, py::arg("executor") = "flowgraph",
           py::arg("broad_phase") = "auto", py::arg("request") = "contacts", py::arg("tolerance") = 0.0,
           py::arg("margin") = 0.0, py::arg("keep_contacts") = 0.0, py::arg("mesh_margin") = false,
           py::arg("contact_hash") = false, py::arg("split") = py::none(),
           "threads: in all, 0 asks oneTBB. executor: 'sequential', 'barrier', 'fused', 'threads', 'flowgraph'. "
           "broad_phase: 'brute',\n"
           "'sweep', 'grid', 'bvh', 'auto'. request: 'collide', 'distance', 'contacts'. tolerance, keep_contacts: "
           "accepted error\n"
           "relative to the bodies' size, [0, 0.1]. margin: m, gaps up to it are reported; of two meshes with "
           "mesh_margin. split: (broad, narrow) "
           "threads.")
      .def("step", &step, py::arg("scene"), py::kw_only(), py::arg("timeout") = py::none(),
           "Finds all contacts; returns the report. timeout: s; then with what is finished, and 'incomplete' among its "
           "issues.")
      .def(
          "contacts", [](const SharedPipeline& p) { return contact_array(list_of(p)); },
          "Of the last step: a structured array a, b (body indices), point, normal (unit, a to b), depth (m), feature.")
      .def(
          "pairs", [](const SharedPipeline& p) { return pair_array(list_of(p)); },
          "Of the last step: a structured array a, b, collide, signed_distance (m), error_bound, first_contact, "
          "contact_count.")
      .def("record_timeline", &record_timeline, "Slices of the steps that follow are recorded, until write_timeline.")
      .def("write_timeline", &write_timeline, py::arg("path"), "A trace as JSON, for Perfetto or the report.");
}

}  // namespace tandem::python
