// The command `tandem run`.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <sstream>

#include "commands.h"
#include "formats/record_file.h"
#include "formats/scene_json.h"
#include "gzip.h"
#include "option_text.h"
#include "progress.h"
#include "run_options.h"
#include "run_output.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {
namespace {

// The options as typed.
struct Options : RunOptions {
  std::string split = "dynamic", balance = "busy", awake = "0";
  bool strict = false;
};

// A signal handler can only communicate through a global variable.
volatile std::sig_atomic_t interrupted = 0;

// While it lives, an interrupt ends the run between two steps, so that no temporary file is left.
class InterruptGuard {
 public:
  InterruptGuard() {
    interrupted = 0;
    before_int_ = std::signal(SIGINT, note);
    before_term_ = std::signal(SIGTERM, note);
    before_hup_ = std::signal(SIGHUP, note);
  }
  ~InterruptGuard() {
    std::signal(SIGINT, before_int_);
    std::signal(SIGTERM, before_term_);
    std::signal(SIGHUP, before_hup_);
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  static void note(int) { interrupted = 1; }
  void (*before_int_)(int);
  void (*before_term_)(int);
  void (*before_hup_)(int);
};

Split read_split(const std::string& text) {
  if (text == "dynamic") return {};
  constexpr std::string_view allowed = "dynamic, or X-Y with X and Y from 1, at most 1024 together";
  const std::size_t dash = text.find('-');
  if (dash == std::string::npos) refuse_option("--split", text, allowed);
  Split split;
  try {
    split.broad = static_cast<int>(whole_option("", text.substr(0, dash), 1, 1023));
    split.narrow = static_cast<int>(whole_option("", text.substr(dash + 1), 1, 1023));
  } catch (const RequestError&) {
    refuse_option("--split", text, allowed);
  }
  if (split.broad + split.narrow > 1024) refuse_option("--split", text, allowed);
  return split;
}

PipelineOptions pipeline_options(const Options& options) {
  constexpr BalanceRule rules[] = {BalanceRule::paper, BalanceRule::busy};
  PipelineOptions out;
  read_run_options(options, out);
  out.balance.rule = named_option("--balance", options.balance, rules);
  out.balance.strict = options.strict;
  out.stay_awake = number_option("--stay-awake", options.awake, 0, longest_awake);
  const Split split = read_split(options.split);
  if (!split.dynamic()) {
    const int sum = split.broad + split.narrow;
    if (out.threads != 0 && out.threads != sum)
      refuse_option("--split", options.split, "X-Y with X + Y = " + options.threads + ", the --threads");
    // The other executors have one group of threads for both phases.
    const bool divides = out.executor == ExecutorKind::threads || out.executor == ExecutorKind::flowgraph;
    out.threads = sum;
    if (divides) out.balance.split = split;
  }
  return out;
}

struct IssueName {
  StepIssue issue;
  std::string_view name;
  std::string_view advice;  // what to change; empty where nothing need be
};
constexpr IssueName issue_names[] = {
    {StepIssue::inexact, "inexact",
     "some depths are not exact (PairAnswer::error_bound); --tolerance says what is accepted"},
    {StepIssue::pool_grew, "pool_grew", ""},
    {StepIssue::ran_on_caller, "ran_on_caller", ""},
    {StepIssue::ended_early, "ended_early", "a stop was requested"},
    {StepIssue::incomplete, "incomplete", "the deadline passed before all pairs were finished"}};

struct StepTimes {
  double detect_ms, response_ms;
};

void write_times(JsonWriter& out, const ExecutionReport& execution, const StepTimes& times) {
  out.key("ms")
      .begin_object()
      .member("update", execution.update_ms)
      .member("broad", execution.broad_ms)
      .member("narrow", execution.narrow_ms)
      .member("detect", execution.detect_ms)
      .member("response", times.response_ms)
      .member("step", times.detect_ms + times.response_ms)
      .member("broad_end", execution.broad_end_ms)
      .member("narrow_end", execution.narrow_end_ms)
      .member("join", execution.join_ms)
      .member("busy", execution.busy_ms)
      .member("awake", execution.awake_ms)
      .end_object();
}

/// Writes the serial time, during which a second thread could do nothing, and its fraction of all work (Amdahl).
void write_serial(JsonWriter& out, const ExecutionReport& execution, const ResponseReport& response) {
  const SerialTimes& serial = execution.serial;
  out.key("serial")
      .begin_object()
      .member("begin_ms", serial.begin)
      .member("update_ms", serial.update)
      .member("broad_ms", serial.broad)
      .member("join_ms", serial.join)
      .member("share", execution.busy_ms > 0 ? serial.sum() / execution.busy_ms : 0)
      .member("response_ms", response.serial_ms)
      .end_object();
}

void write_decision(JsonWriter& out, const BalanceDecision& decision) {
  out.key("decision")
      .begin_object()
      .member("action", name(decision.action))
      .member("reason", decision.reason)
      .member("before", std::string_view(written(decision.before)))
      .member("after", std::string_view(written(decision.after)))
      .member("broad_ms", decision.broad_ms)
      .member("narrow_ms", decision.narrow_ms)
      .member("measure", decision.measure)
      .member("measure_before", decision.measure_before)
      .end_object();
}

void write_memory(JsonWriter& out, const SceneMemory& scene, const PipelineMemory& pipeline) {
  out.key("memory_bytes")
      .begin_object()
      .member("scene_bodies", scene.bodies)
      .member("scene_shapes", scene.shapes)
      .member("scene_shape_names", scene.shape_names)
      .member("pipeline_bodies", pipeline.bodies)
      .member("broad_phase", pipeline.broad_phase)
      .member("executor", pipeline.executor)
      .member("kept_answers", pipeline.kept_answers)
      .member("contacts", pipeline.contacts)
      .member("total", scene.total() + pipeline.total())
      .end_object();
}

struct StepMemory {
  SceneMemory scene;
  PipelineMemory pipeline;
};

void write_step(JsonWriter& out, const PipelineOptions& options, const StepReport& report,
                const ResponseReport& response, const StepTimes& times, const StepMemory& memory) {
  const ExecutionReport& execution = report.execution;
  out.begin_object()
      .member("step", report.step)
      .member("bodies", report.bodies)
      .member("candidate_pairs", execution.candidate_pairs)
      .member("colliding_pairs", report.colliding_pairs)
      .member("contacts", report.contacts)
      .member("contact_hash", std::string_view(hex(report.contact_hash)))
      .member("split", std::string_view(written(execution.split)))
      .member("control_step", execution.decision.control_step)
      .member("max_depth", report.max_depth)
      .member("kinetic_energy", response.kinetic_energy);
  write_times(out, execution, times);
  write_serial(out, execution, response);
  write_memory(out, memory.scene, memory.pipeline);
  out.member("gaps", report.gaps)
      .member("margin", options.answer.margin)
      .member("kept_pairs", report.kept_pairs)
      .member("computed_pairs", report.computed_pairs)
      .member("kept_error_bound", report.kept_error_bound)
      .member("executor", name(options.executor))
      .member("threads", execution.threads)
      .member("broadphase", name(report.broad_phase))
      .member("broadphase_reason", report.broad_phase_reason)
      .member("batches", execution.batches)
      .member("queue_high_water", execution.queue_high_water);
  out.key("issues").begin_array();
  for (const auto& [issue, issue_name, advice] : issue_names)
    if ((execution.issues & bit(issue)) != 0) out.value(issue_name);
  out.end_array();
  write_decision(out, execution.decision);
  out.end_object();
}

// The files of a run: opened before the first step, renamed to their names after the last.
struct Outputs : RunFiles {
  std::optional<OutputFile> record;

  explicit Outputs(const Options& options) {
    require_different(files_of(options));
    open(options);
    if (!options.record.empty()) record.emplace("--record", options.record);
  }
  void commit() { commit_all({&json, &contacts, &trace, &record}); }
};

// Collects the data of the table at the end.
class Summary {
 public:
  void add(const StepReport& report, const StepTimes& times) {
    const ExecutionReport& execution = report.execution;
    update_.push_back(execution.update_ms);
    broad_.push_back(execution.broad_ms);
    narrow_.push_back(execution.narrow_ms);
    detect_.push_back(execution.detect_ms);
    response_.push_back(times.response_ms);
    awake_.push_back(execution.awake_ms);
    step_.push_back(times.detect_ms + times.response_ms);
    for (std::size_t i = 0; i < std::size(issue_names); ++i)
      issues_[i] += (execution.issues & bit(issue_names[i].issue)) != 0;
    last_ = report;
  }

  std::string table(const Scene& scene, const PipelineOptions& options) const {
    const ExecutionReport& execution = last_.execution;
    std::ostringstream out;
    out << "scene            " << scene.name << ", " << last_.bodies << " bodies, " << step_.size() << " steps\n"
        << "run by           " << name(options.executor) << ", " << execution.threads << " threads, split "
        << (options.balance.split.dynamic() ? "dynamic" : "fixed") << ", last " << written(execution.split) << '\n'
        << "broad phase      "
        << (last_.broad_phase_reason.empty() ? name(last_.broad_phase) : last_.broad_phase_reason) << '\n'
        << "request          " << name(options.answer.request) << '\n'
        << "last step        " << execution.candidate_pairs << " candidate pairs, " << last_.colliding_pairs
        << " colliding, " << last_.contacts << " contacts, largest depth " << last_.max_depth << " m\n"
        << "contact hash     " << hex(last_.contact_hash) << '\n';
    if (options.answer.keep_contacts > 0)
      out << "kept             " << last_.kept_pairs << " pairs, " << last_.computed_pairs
          << " computed, error at most " << last_.kept_error_bound << " m\n";
    out.precision(3);
    out << std::fixed << "ms, medians      update " << median(update_) << ", broad " << median(broad_) << ", narrow "
        << median(narrow_) << ", detect " << median(detect_) << ", response " << median(response_) << ", step "
        << median(step_);
    if (options.stay_awake > 0) out << ", awake " << median(awake_);
    out << '\n';
    // Normal conditions are reported by --json alone.
    for (std::size_t i = 0; i < std::size(issue_names); ++i)
      if (issues_[i] > 0 && !issue_names[i].advice.empty())
        out << "warning          " << issue_names[i].name << " in " << issues_[i] << " steps: " << issue_names[i].advice
            << '\n';
    return out.str();
  }

 private:
  std::vector<double> update_, broad_, narrow_, detect_, response_, step_, awake_;
  std::size_t issues_[std::size(issue_names)] = {};
  StepReport last_;
};

constexpr std::size_t most_slices = 200'000;  // of a timeline: some 40 MB, as much as a viewer opens easily

void write_trace(const Timeline& timeline, OutputFile& file, std::string_view path) {
  if (!path.ends_with(".gz")) return timeline.write(file.stream());
  std::ostringstream text;
  timeline.write(text);
  file.append(gzipped(text.view()));
}

/// Runs the steps of a scene and writes the requested output.
class Simulation {
 public:
  Simulation(const Options& options, const PipelineOptions& how, Scene& scene, Outputs& outputs)
      : how_(how),
        scene_(scene),
        outputs_(outputs),
        writes_gaps_(!options.margin.empty()),
        pipeline_(how),
        response_({.threads = how.executor == ExecutorKind::sequential ? 1 : how.threads}) {
    if (outputs.trace) pipeline_.record_to(&timeline_);
    if (outputs.record) record_.emplace(*outputs.record, scene);
  }

  void run(std::uint64_t steps) {
    const InterruptGuard guard;
    Progress progress("run", steps);
    for (std::uint64_t step = 0; step < steps; ++step) {
      if (interrupted != 0) throw std::runtime_error("interrupted before step " + std::to_string(step));
      advance(step);
      progress.at(step + 1);
    }
  }

  const Summary& summary() const { return summary_; }
  const Timeline& timeline() const { return timeline_; }
  /// The number of steps in the timeline.
  std::uint64_t traced() const { return traced_; }

 private:
  void advance(std::uint64_t step) {
    const auto begin = std::chrono::steady_clock::now();
    const StepReport report = pipeline_.step(scene_);
    if (outputs_.trace && timeline_.slices() < most_slices)
      traced_ = step + 1;
    else
      pipeline_.record_to(nullptr);
    StepTimes times{ms_since(begin), 0};
    const ContactList& found = pipeline_.contacts();
    if (record_) record_->step(report.step, report.contact_hash, scene_, found);
    if (outputs_.contacts) {
      write_contacts(line_, report.step, found.pairs, writes_gaps_, [&](const PairResult& p) { return found.of(p); });
      append_line(*outputs_.contacts, line_);
    }
    const auto response_begin = std::chrono::steady_clock::now();
    const ContactList none;  // without contacts a response lets the bodies fly
    const ResponseReport moved = response_.step(scene_, scene_.request == Request::contacts ? found : none);
    times.response_ms = ms_since(response_begin);
    if (outputs_.json) {
      write_step(line_, how_, report, moved, times, {scene_.memory(), pipeline_.memory()});
      append_line(*outputs_.json, line_);
    }
    summary_.add(report, times);
  }

  const PipelineOptions& how_;
  Scene& scene_;
  Outputs& outputs_;
  bool writes_gaps_;
  Timeline timeline_;
  Pipeline pipeline_;
  std::uint64_t traced_ = 0;
  std::optional<RecordWriter> record_;
  Response response_;
  Summary summary_;
  JsonWriter line_;
};

int run(const Options& options, DescriptorBuffer& out) {
  const std::uint64_t steps = steps_of(options);
  PipelineOptions how = pipeline_options(options);
  Scene scene = load_scene(options, how.answer);
  const tbb::global_control limit = allowed_threads(how.threads);
  Outputs outputs(options);
  Simulation simulation(options, how, scene, outputs);
  simulation.run(steps);
  if (outputs.trace) write_trace(simulation.timeline(), *outputs.trace, options.trace);
  outputs.commit();
  out.append(simulation.summary().table(scene, how));
  if (outputs.trace && simulation.traced() < steps)
    out.append("trace            the first " + std::to_string(simulation.traced()) +
               " steps alone: " + std::to_string(most_slices) + " slices are kept\n");
  return 0;
}

}  // namespace

void add_run_command(CLI::App& program, DescriptorBuffer& out, int& status) {
  CLI::App* command = program.add_subcommand("run", "simulate a scene");
  const auto o = std::make_shared<Options>();
  o->threads = "0";
  add_run_options(*command, *o,
                  {.threads = "threads in all, 0 to 1024, the caller counted; 0 asks the runtime",
                   .contacts = "write the contacts of every step to this FILE",
                   .trace = "write a timeline to this FILE, for Perfetto; compressed if it ends in .gz",
                   .record = "write poses and contacts of every step to this FILE (docs/record-format.md)"});
  const auto add = [&](const char* option, const char* type, std::string& value, const char* text) {
    add_text(*command, option, type, value, text);
  };
  add("--split", "X-Y", o->split, "threads for broad and narrow phase (threads, flowgraph), or dynamic");
  add("--balance", "NAME", o->balance, "rule for a dynamic split: paper or busy");
  add("--stay-awake", "US", o->awake, "flowgraph: microseconds that workers stay awake after a step, 0 to 1e5");
  command->add_flag("--strict", o->strict, "flowgraph, threads: no thread helps the other phase, as in the paper");
  command->footer(
      "Bodies respond to contacts only with the request contacts; else they fly through each other.\n"
      "Output files appear under their names when the run is done.\n"
      "Exit status: 0 done, 1 the work failed, 2 the request was wrong.");
  command->callback([o, &out, &status] { status = run(*o, out); });
}

}  // namespace tandem
