// Bindings of the pipeline.
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

// Options are keyword arguments, each put where C++ has it.
std::unique_ptr<SharedPipeline> pipeline(int threads, const std::string& executor, const std::string& broad_phase,
                                         const AnswerOptions& answer, const BalanceOptions& balance,
                                         const PairBatchOptions& batches, const SharingOptions& sharing,
                                         double stay_awake) {
  PipelineOptions options;
  options.threads = threads;
  options.executor = named(executor, "executor", executor_kinds);
  options.broad_phase = named(broad_phase, "broad_phase",
                              std::array{BroadPhaseKind::brute, BroadPhaseKind::sweep, BroadPhaseKind::grid,
                                         BroadPhaseKind::bvh, BroadPhaseKind::automatic});
  options.answer = answer;
  options.balance = balance;
  options.batches = batches;
  options.sharing = sharing;
  options.stay_awake = stay_awake;
  return std::make_unique<SharedPipeline>(std::move(options));
}

BalanceOptions balance_options(std::optional<std::array<int, 2>> split, const std::string& rule, bool strict) {
  BalanceOptions balance;
  if (split) balance.split = {(*split)[0], (*split)[1]};
  balance.rule = named(rule, "balance", std::array{BalanceRule::paper, BalanceRule::busy});
  balance.strict = strict;
  return balance;
}

SharingOptions sharing_options(const std::string& form, double short_step_ms) {
  constexpr std::array forms{StepForm::automatic, StepForm::caller, StepForm::overlapped, StepForm::ordered};
  return {named(form, "form", forms), short_step_ms};
}

void bind_making(py::class_<SharedPipeline>& pipelines) {
  pipelines.def(
      py::init([](int threads, const std::string& executor, const std::string& broad_phase, const std::string& asked,
                  double tolerance, double margin, double keep_contacts, bool mesh_margin, bool contact_hash,
                  std::optional<std::array<int, 2>> split, const std::string& balance, bool strict,
                  std::size_t batch_pairs, std::size_t queue_capacity, const std::string& form, double short_step_ms,
                  double stay_awake) {
        return pipeline(threads, executor, broad_phase,
                        {request(asked), tolerance, margin, mesh_margin, keep_contacts, contact_hash},
                        balance_options(split, balance, strict), {batch_pairs, queue_capacity},
                        sharing_options(form, short_step_ms), stay_awake);
      }),
      py::kw_only(), py::arg("threads") = 0, py::arg("executor") = "flowgraph", py::arg("broad_phase") = "auto",
      py::arg("request") = "contacts", py::arg("tolerance") = 0.0, py::arg("margin") = 0.0,
      py::arg("keep_contacts") = 0.0, py::arg("mesh_margin") = false, py::arg("contact_hash") = false,
      py::arg("split") = py::none(), py::arg("balance") = "busy", py::arg("strict") = false,
      py::arg("batch_pairs") = PairBatchOptions{}.pairs, py::arg("queue_capacity") = PairBatchOptions{}.queue_capacity,
      py::arg("form") = "automatic", py::arg("short_step_ms") = SharingOptions{}.short_step_ms,
      py::arg("stay_awake") = 0.0,
      "threads: in all, 0 asks oneTBB. executor: 'sequential', 'barrier', 'fused', 'threads', 'flowgraph'. "
      "broad_phase: "
      "'brute',\n"
      "'sweep', 'grid', 'bvh', 'auto'. request: 'collide', 'distance', 'contacts'. tolerance, keep_contacts: accepted "
      "error\n"
      "relative to the bodies' size, [0, 0.1]. margin: m, gaps up to it are reported; of two meshes with mesh_margin.\n"
      "How steps are run, which changes no answer: split: (broad, narrow) threads, None moves them by the rule "
      "balance, "
      "'busy' or\n"
      "'paper'; strict: no help across the phases. batch_pairs, [1, 65536]: at most, from phase to phase; "
      "queue_capacity:\n"
      "batches that wait, 0 chooses. form: 'automatic', 'caller', 'overlapped', 'ordered'. short_step_ms: steps of "
      "less work "
      "stay\n"
      "on the caller. stay_awake: us, [0, 100000], that workers stay awake after a step.");
}

StepReport step(SharedPipeline& pipeline, const SharedScene& scene, std::optional<double> timeout) {
  const auto deadline = deadline_after(timeout);
  return pipeline.change(
      [&](Detector& d) { return scene.read([&](const Scene& s) { return d.pipeline.step(s, {}, deadline); }); });
}

// The list is copied while no step may run, since making an array takes the GIL.
ContactList list_of(const SharedPipeline& pipeline) {
  return pipeline.read([](const Detector& d) { return d.pipeline.contacts(); });
}

PipelineMemory memory_of(const SharedPipeline& pipeline) {
  return pipeline.read([](const Detector& d) { return d.pipeline.memory(); });
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
      .def_property_readonly("broad_phase_reason",
                             [](const StepReport& r) { return std::string(r.broad_phase_reason); })
      .def_property_readonly("candidate_pairs", of_execution(&ExecutionReport::candidate_pairs))
      .def_property_readonly("heavy_pairs", of_execution(&ExecutionReport::heavy_pairs), "in batches of their own")
      .def_property_readonly("batches", of_execution(&ExecutionReport::batches))
      .def_property_readonly("queue_high_water", of_execution(&ExecutionReport::queue_high_water),
                             "batches waiting at most")
      .def_property_readonly("update_ms", of_execution(&ExecutionReport::update_ms), "wall: poses to boxes")
      .def_property_readonly("heavy_ms", of_execution(&ExecutionReport::heavy_ms), "busy, of narrow_ms")
      .def_property_readonly("broad_end_ms", of_execution(&ExecutionReport::broad_end_ms),
                             "wall, to the last broad block")
      .def_property_readonly("narrow_end_ms", of_execution(&ExecutionReport::narrow_end_ms),
                             "wall, to the last narrow batch")
      .def_property_readonly("join_ms", of_execution(&ExecutionReport::join_ms), "wall: putting answers in order")
      .def_property_readonly("busy_ms", of_execution(&ExecutionReport::busy_ms), "summed over threads")
      .def_property_readonly("awake_ms", of_execution(&ExecutionReport::awake_ms),
                             "of workers that stayed awake, summed")
      .def_property_readonly(
          "serial_ms", [](const StepReport& r) { return r.execution.serial.sum(); },
          "wall: what one thread did while no other could")
      .def_property_readonly(
          "decision",
          [](const StepReport& r) {
            return py::make_tuple(std::string(name(r.execution.decision.action)),
                                  std::string(r.execution.decision.reason));
          },
          "(what the balancer did after the step, why)")
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
  py::class_<SharedPipeline> pipelines(
      m, "Pipeline", "Detects collisions in a scene, step by step; the answer does not depend on threads or executor.");
  bind_making(pipelines);
  pipelines
      .def("step", &step, py::arg("scene"), py::kw_only(), py::arg("timeout") = py::none(),
           "Finds all contacts; returns the report. timeout: s; then with what is finished, and 'incomplete' among its "
           "issues.")
      .def(
          "contacts", [](const SharedPipeline& p) { return contact_array(list_of(p)); },
          "Of the last step: a structured array a, b (body indices), point, normal (unit, a to b), depth (m), feature.")
      .def(
          "pairs", [](const SharedPipeline& p) { return pair_array(list_of(p)); },
          "Of the last step: a structured array a, b, collide, signed_distance (m), error_bound, first_contact, "
          "contact_count,\nstatus (0 ok, 1 inexact, 2 unproven: a mesh's depth is its deepest contact's, without a "
          "bound).")
      .def_property_readonly(
          "memory", [](const SharedPipeline& p) { return memory_of(p).total(); }, "Bytes held between steps.")
      .def_property_readonly(
          "memory_by_part",
          [](const SharedPipeline& p) {
            const PipelineMemory held = memory_of(p);
            return by_part({{"bodies", held.bodies},
                            {"broad_phase", held.broad_phase},
                            {"executor", held.executor},
                            {"kept_answers", held.kept_answers},
                            {"contacts", held.contacts}});
          },
          "The same by parts: bodies, broad_phase, executor, kept_answers, contacts.")
      .def("record_timeline", &record_timeline, "Slices of the steps that follow are recorded, until write_timeline.")
      .def("write_timeline", &write_timeline, py::arg("path"), "A trace as JSON, for Perfetto or the report.");
}

}  // namespace tandem::python
