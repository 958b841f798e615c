// The program tandem-mpi: `tandem run` on the ranks of MPI. Rank 0 writes; the others are silent except for failures.
#include <mpi.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iostream>
#include <optional>
#include <span>
#include <sstream>
#include <vector>

#include "formats/scene_json.h"
#include "option_text.h"
#include "progress.h"
#include "rank_record.h"
#include "rank_trace.h"
#include "run_options.h"
#include "run_output.h"
#include "tandem/mpi/checkpoint.h"
#include "tandem/mpi/pipeline.h"
#include "tandem/mpi/response.h"

namespace tandem {
namespace {

using Clock = std::chrono::steady_clock;

// The options as typed; empty: not given.
struct Options : RunOptions {
  std::string rebalance = "on", response = "all", patience = "0", checkpoint, every = "100", restart;
};

// For the message of a fatal signal's handler.
volatile std::sig_atomic_t rank_now = 0, step_now = 0;

// Reports the signal that ends a rank; uses only calls permitted in a signal handler.
void tell_signal(int signal) {
  char text[96];
  std::size_t length = 0;
  const auto add = [&](const char* part) {
    while (*part != 0 && length < sizeof text - 1) text[length++] = *part++;
  };
  const auto number = [&](int value) {
    char digits[12];
    int count = 0;
    do digits[count++] = static_cast<char>('0' + value % 10);
    while ((value /= 10) != 0);
    while (count > 0 && length < sizeof text - 1) text[length++] = digits[--count];
  };
  add("tandem-mpi: rank ");
  number(rank_now);
  add(", step ");
  number(step_now);
  add(": signal ");
  number(signal);
  add("\n");
  if (::write(2, text, length) < 0) _exit(1);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

mpi::Options pipeline_options(const Options& options) {
  mpi::Options out;
  read_run_options(options, out.rank);
  if (options.rebalance != "on" && options.rebalance != "off")
    refuse_option("--rebalance", options.rebalance, "on, off");
  if (options.response != "all" && options.response != "none")
    refuse_option("--response", options.response, "all, none");
  out.rebalance.enabled = options.rebalance == "on";
  out.patience = number_option("--patience", options.patience, 0, 1e6);
  return out;
}

// Adds the scene's bodies, with their indices as ids, each by one rank; the first step sends them to their owners. Each
// rank adds a range of indices, as neighbours in a scene have near indices.
void add_bodies(mpi::Pipeline& pipeline, const Scene& scene, bool bodies) {
  for (std::uint32_t k = 0; k < scene.shapes().size(); ++k)
    pipeline.add_shape(scene.shapes()[k], std::string(scene.shape_name(k)));
  pipeline.set_gravity(scene.gravity);
  pipeline.set_dt(scene.dt);
  const auto share = [&](int rank) {
    return static_cast<std::uint32_t>(scene.indices() * static_cast<std::size_t>(rank) /
                                      static_cast<std::size_t>(pipeline.ranks()));
  };
  for (std::uint32_t i = share(pipeline.rank()); bodies && i < share(pipeline.rank() + 1); ++i)
    pipeline.add_body(i, {.shape = scene.shape_id(scene.id(i)),
                          .pose = scene.poses()[i],
                          .velocity = scene.velocities()[i],
                          .angular_velocity = scene.angular_velocities()[i],
                          .density = scene.densities()[i],
                          .is_static = scene.is_static()[i] != 0,
                          .is_sensor = scene.is_sensor()[i] != 0,
                          .continuous = scene.continuous()[i] != 0,
                          .group = scene.groups()[i],
                          .mask = scene.masks()[i]});
}

// The measurements of one rank that the others do not know.
struct RankNumbers {
  double owned = 0, copies = 0, detect_cpu_ms = 0, exchange_cpu_ms = 0;
};

// The measurements of all ranks, on rank 0.
std::vector<RankNumbers> gathered(const mpi::RankReport& report, int ranks) {
  const RankNumbers own{static_cast<double>(report.owned), static_cast<double>(report.copies), report.detect_cpu_ms,
                        report.exchange_cpu_ms};
  std::vector<RankNumbers> all(static_cast<std::size_t>(ranks));
  constexpr int numbers = sizeof(RankNumbers) / sizeof(double);
  MPI_Gather(&own, numbers, MPI_DOUBLE, all.data(), numbers, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  return all;
}

void write_ranks(JsonWriter& out, const std::vector<RankNumbers>& ranks) {
  out.key("by_rank").begin_array();
  for (const RankNumbers& rank : ranks)
    out.begin_object()
        .member("owned", rank.owned)
        .member("copies", rank.copies)
        .member("detect_cpu_ms", rank.detect_cpu_ms)
        .member("exchange_cpu_ms", rank.exchange_cpu_ms)
        .end_object();
  out.end_array();
}

void write_step(JsonWriter& out, const Options& options, const mpi::Report& report,
                const mpi::RankResponseReport& response, double response_ms, const std::vector<RankNumbers>& ranks,
                std::optional<std::uint64_t> list_hash) {
  const ExecutionReport& execution = report.rank.detection.execution;
  out.begin_object()
      .member("step", report.step)
      .member("bodies", report.bodies)
      .member("candidate_pairs", report.pairs)
      .member("colliding_pairs", report.colliding_pairs)
      .member("contacts", report.contacts)
      .member("kept_pairs", report.kept_pairs)
      .member("contact_hash", std::string_view(hex(report.contact_hash)))
      .member("split", std::string_view(written(execution.split)))
      .member("max_depth", report.max_depth)
      .member("kinetic_energy", response.response.kinetic_energy);
  // Times of rank 0, except for the loads; also the traffic of the response.
  out.key("ms")
      .begin_object()
      .member("exchange", report.rank.exchange_ms)
      .member("exchange_wait", report.rank.exchange_wait_ms)
      .member("slowest_exchange_cpu", report.slowest_exchange_cpu_ms)
      .member("slowest_detect_cpu", report.slowest_detect_cpu_ms)
      .member("update", execution.update_ms)
      .member("broad", execution.broad_ms)
      .member("narrow", execution.narrow_ms)
      .member("detect", execution.detect_ms)
      .member("wait", report.rank.wait_ms)
      .member("response", response_ms)
      .member("gather", response.gather_ms)
      .member("response_wait", response.wait_ms)
      .member("step", report.rank.step_ms + response_ms)
      .member("slowest_load", report.slowest_load_ms)
      .member("mean_load", report.mean_load_ms)
      .end_object();
  out.member("gaps", report.gaps)
      .member("ranks", ranks.size())
      .member("threads", execution.threads)
      .member("executor", std::string_view(options.executor))
      .member("copies", report.copies)
      .member("moved_away", report.moved_away)
      .member("bytes_sent", report.bytes_sent)
      .member("messages_sent", report.messages_sent)
      .member("response_bytes_sent", response.bytes_sent)
      .member("response_messages_sent", response.messages_sent);
  if (list_hash) out.member("list_hash", std::string_view(hex(*list_hash)));
  write_ranks(out, ranks);
  const mpi::RebalanceDecision& decision = report.rebalance;
  out.key("rebalance")
      .begin_object()
      .member("action", name(decision.action))
      .member("reason", decision.reason)
      .member("control_step", decision.control_step)
      .member("imbalance", decision.imbalance)
      .member("gain_ms", decision.gain_ms)
      .member("migration_ms", decision.migration_ms)
      .end_object();
  out.end_object();
}

// Collects the data of the table at the end; rank 0's, and what all ranks know.
class Summary {
 public:
  void add(const mpi::Report& report, double response_ms) {
    exchange_.push_back(report.rank.exchange_ms);
    detect_.push_back(report.rank.detection.execution.detect_ms);
    wait_.push_back(report.rank.wait_ms);
    response_.push_back(response_ms);
    step_.push_back(report.rank.step_ms + response_ms);
    bytes_.push_back(static_cast<double>(report.bytes_sent));
    moved_ += report.moved_away;
    cuts_ += report.rebalance.action == BalanceAction::change ? 1 : 0;
    taken_back_ += report.rebalance.action == BalanceAction::revert ? 1 : 0;
    last_ = report;
  }
  std::string table(const std::string& scene, const mpi::Options& options, int ranks) const {
    std::ostringstream out;
    out << "scene            " << scene << ", " << last_.bodies << " bodies, " << step_.size() << " steps\n"
        << "run by           " << ranks << " ranks of " << last_.rank.detection.execution.threads << " threads, "
        << name(options.rank.executor) << '\n'
        << "request          " << name(options.rank.answer.request) << '\n'
        << "last step        " << last_.pairs << " candidate pairs, " << last_.colliding_pairs << " colliding, "
        << last_.contacts << " contacts, largest depth " << last_.max_depth << " m\n"
        << "contact hash     " << hex(last_.contact_hash) << ", the same for any number of ranks\n";
    out.precision(3);
    out << std::fixed << "loads            slowest rank " << last_.slowest_load_ms << " ms, mean " << last_.mean_load_ms
        << " ms; " << cuts_ << " cuts, " << taken_back_ << " taken back, " << moved_ << " bodies changed owner\n"
        << "exchange         " << last_.copies << " copies, " << median(bytes_) / 1e6 << " MB a step, median\n"
        << "ms, medians      exchange " << median(exchange_) << ", detect " << median(detect_) << ", wait "
        << median(wait_) << ", response " << median(response_) << ", step " << median(step_) << " (rank 0)\n";
    return out.str();
  }

 private:
  std::vector<double> exchange_, detect_, wait_, response_, step_, bytes_;
  std::uint64_t moved_ = 0;
  int cuts_ = 0, taken_back_ = 0;
  mpi::Report last_;
};

// The output files, on rank 0; the others have none.
struct Outputs : RunFiles {
  Outputs(const Options& options, int rank) {
    std::string fault;
    try {
      auto files = files_of(options);
      files.emplace_back("--checkpoint", options.checkpoint);
      require_different(files);
      if (rank == 0) open(options);
    } catch (const std::exception& error) {
      fault = error.what();
    }
    std::array<char, 512> text{};  // of rank 0: all ranks end alike
    std::copy_n(fault.begin(), std::min(fault.size(), text.size() - 1), text.begin());
    MPI_Bcast(text.data(), static_cast<int>(text.size()), MPI_CHAR, 0, MPI_COMM_WORLD);
    if (text[0] != 0) throw RequestError(text.data());
  }
  // Writes the contacts of a step; called by all ranks.
  void write_contacts_of(const mpi::Pipeline& pipeline, std::uint64_t step, bool gaps) {
    const mpi::GatheredContacts all = pipeline.gather(0);
    if (!contacts) return;
    JsonWriter line;
    write_contacts(line, step, all.pairs, gaps, [&](const mpi::GatheredPair& pair) {
      return std::span(all.contacts).subspan(pair.first_contact, pair.contact_count);
    });
    append_line(*contacts, line);
  }
  void commit() { commit_all({&json, &contacts, &trace}); }
};

// Begins anew as a run does that continues from a checkpoint.
void begin_anew(mpi::Pipeline& pipeline, std::optional<mpi::Response>& response) {
  pipeline.begin_anew();
  if (response) response->begin_anew();
}

void run(const Options& options) {
  const std::uint64_t steps = steps_of(options);
  const std::uint64_t every = whole_option("--checkpoint-every", options.every, 1, 1'000'000'000);
  mpi::Options how = pipeline_options(options);
  Scene scene = load_scene(options, how.rank.answer);
  const std::string scene_name = scene.name;
  const tbb::global_control limit = allowed_threads(how.rank.threads);
  mpi::Pipeline pipeline(MPI_COMM_WORLD, how);
  add_bodies(pipeline, scene, options.restart.empty());
  Outputs outputs(options, pipeline.rank());
  std::optional<RankRecord> record;
  if (!options.record.empty()) record.emplace(MPI_COMM_WORLD, options.record, scene);
  scene = Scene();  // each rank keeps only its own bodies
  if (!options.restart.empty()) mpi::Checkpoint::read(pipeline, options.restart);
  std::optional<mpi::Response> response;
  if (options.response == "all")
    response.emplace(pipeline,
                     ResponseOptions{.threads = how.rank.executor == ExecutorKind::sequential ? 1 : how.rank.threads});
  std::optional<RankTrace> trace;
  if (!options.trace.empty()) trace.emplace(MPI_COMM_WORLD, pipeline);
  Summary summary;
  JsonWriter line;
  {
    std::optional<Progress> progress;
    if (pipeline.rank() == 0) progress.emplace("run", steps);
    for (std::uint64_t done = 0; done < steps; ++done) {
      const mpi::Report report = pipeline.step();
      step_now = static_cast<std::sig_atomic_t>(report.step);
      if (trace) trace->record(pipeline);
      std::optional<std::uint64_t> list_hash;
      if (record) list_hash = record->step(pipeline, report.step);
      if (!options.contacts.empty()) outputs.write_contacts_of(pipeline, report.step, !options.margin.empty());
      const auto begin = Clock::now();
      mpi::RankResponseReport moved;
      if (response) moved = response->step(how.rank.answer.request == Request::contacts);
      const double response_ms = ms_since(begin);
      std::vector<RankNumbers> ranks;
      if (!options.json.empty()) ranks = gathered(report.rank, pipeline.ranks());
      if (outputs.json) {
        write_step(line, options, report, moved, response_ms, ranks, list_hash);
        append_line(*outputs.json, line);
      }
      if (!options.checkpoint.empty() && (report.step + 1) % every == 0) {
        mpi::Checkpoint::write(pipeline, options.checkpoint);
        begin_anew(pipeline, response);
      }
      summary.add(report, response_ms);
      if (progress) progress->at(done + 1);
    }
  }
  if (trace) trace->write(outputs.trace ? &*outputs.trace : nullptr, options.trace);
  if (record) record->commit();
  outputs.commit();
  if (pipeline.rank() != 0) return;
  std::cout << summary.table(scene_name, how, pipeline.ranks());
  if (trace && trace->is_full()) std::cout << "trace            the first " << trace->steps() << " steps alone\n";
  std::cout << std::flush;
}

void add_run(CLI::App& program, Options& o) {
  CLI::App* command = program.add_subcommand("run", "simulate a scene");
  o.threads = "1";
  add_run_options(*command, o,
                  {.threads = "threads of each rank, 0 to 1024; 0 asks the runtime",
                   .contacts = "write the contacts of every step to this FILE: gathered on rank 0",
                   .trace = "write a timeline of all ranks to this FILE, for Perfetto; compressed if it ends in .gz",
                   .record = "write poses and contacts of every step to this FILE, by all ranks at once"});
  const auto add = [&](const char* option, const char* type, std::string& value, const char* text) {
    add_text(*command, option, type, value, text);
  };
  add("--rebalance", "on|off", o.rebalance, "cut regions again by measured costs");
  add("--response", "all|none", o.response,
      "all: bodies move, each rank solving its share of the contacts; none: nothing moves");
  add("--checkpoint", "FILE", o.checkpoint, "write all bodies to this FILE at intervals (--checkpoint-every)");
  add("--checkpoint-every", "N", o.every, "steps from one checkpoint to the next");
  add("--restart", "FILE", o.restart, "go on from this checkpoint of the same scene, on any number of ranks");
  add("--patience", "S", o.patience, "seconds after which a rank that waits for another ends the job; 0: never");
  command->footer(
      "Start it with mpirun: mpirun -n 4 tandem-mpi run spheres-on-plane --bodies 100000 --steps 100\n"
      "Exit status: 0 done, 1 the work failed, 2 the request was wrong.");
  command->callback([&o] { run(o); });
}

enum Status { done = 0, work_failed = 1, request_wrong = 2 };

int run_program(int count, char** arguments, int rank) {
  CLI::App program("Collision detection on the ranks of MPI.", "tandem-mpi");
  program.set_version_flag("--version", "tandem-mpi " TANDEM_VERSION);
  Options options;
  add_run(program, options);
  program.require_subcommand(1);
  try {
    program.parse(count, arguments);
  } catch (const CLI::Success& asked) {
    std::ostringstream help, unused;
    program.exit(asked, help, unused);
    if (rank == 0) std::cout << help.str() << std::flush;
  } catch (const CLI::ParseError& error) {
    throw RequestError(error.what() + std::string(", allowed: what --help lists"));
  }
  return done;
}

// Prints an error. All ranks get here with the same error, except where memory runs out.
int complain(const char* what, int rank, Status status) {
  if (rank == 0) std::cerr << "tandem-mpi: " << what << std::endl;
  return status;
}

}  // namespace
}  // namespace tandem

int main(int count, char** arguments) {
  using namespace tandem;
  int provided = 0, rank = 0;
  MPI_Init_thread(&count, &arguments, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  rank_now = rank;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(signal, tell_signal);
  int status = done;
  try {
    status = run_program(count, arguments, rank);
  } catch (const std::invalid_argument& error) {
    status = complain(error.what(), rank, request_wrong);
  } catch (const mpi::StepError& error) {
    status = complain(error.what(), rank, work_failed);
  } catch (const std::exception& error) {
    // The others may be waiting for this rank.
    std::cerr << "tandem-mpi: rank " << rank << ", step " << step_now << ": " << error.what() << std::endl;
    MPI_Abort(MPI_COMM_WORLD, work_failed);
  }
  MPI_Finalize();
  return status;
}
