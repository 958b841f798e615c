// The command line of tandem-bench.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "benches.h"
#include "formats/input_error.h"
#include "formats/input_limits.h"
#include "formats/output_file.h"
#include "option_text.h"
#include "report.h"
#include "tandem/engine/builtin_scenes.h"

namespace tandem::bench {
namespace {

// The options as typed; empty: not given.
struct Options {
  std::string json, scenes, threads, steps, repeat, bodies, kinds, poses, sizes, contestants;
  bool quick = false;
};

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

std::vector<std::string> builtin_names() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) names.emplace_back(scene.name);
  return names;
}

/// Converts the options; `scenes`: the names permitted for --scene.
Settings read(const Options& options, const std::vector<std::string>& scenes) {
  Settings settings;
  settings.scenes = split_list(options.scenes);
  for (const std::string& name : settings.scenes)
    if (std::find(scenes.begin(), scenes.end(), name) == scenes.end())
      refuse_option("--scene", name, fmt::format("{}", fmt::join(scenes, ", ")));
  for (const std::string& part : split_list(options.threads))
    settings.threads.push_back(static_cast<int>(whole_option("--threads", part, 1, 1024)));
  if (!options.steps.empty()) settings.steps = static_cast<int>(whole_option("--steps", options.steps, 1, 1'000'000));
  if (!options.repeat.empty()) settings.repeat = static_cast<int>(whole_option("--repeat", options.repeat, 1, 10'000));
  if (!options.bodies.empty()) settings.bodies = whole_option("--bodies", options.bodies, 1, 1'000'000);
  settings.kinds = split_list(options.kinds);
  if (!options.poses.empty()) settings.poses = whole_option("--poses", options.poses, 1, 100'000);
  for (const std::string& part : split_list(options.sizes))
    settings.sizes.push_back(whole_option("--sizes", part, 1, 10'000'000));
  settings.contestants = split_list(options.contestants);
  settings.quick = options.quick;
  return settings;
}

void run(const Bench& bench, const Options& options, const std::vector<std::string>& scenes) {
  const Settings settings = read(options, scenes);
  std::optional<OutputFile> json;
  if (!options.json.empty()) json.emplace("--json", options.json);
  // More threads than cores are permitted where they are asked for; the bench of the flow graph uses up to twice the
  // cores.
  const int most = settings.threads.empty() ? std::max(4, 2 * tbb::info::default_concurrency())
                                            : *std::max_element(settings.threads.begin(), settings.threads.end());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(std::max(most, tbb::info::default_concurrency())));
  const Findings findings = bench(settings);
  if (json) {
    json->append(to_json(findings).dump(1) + "\n");
    json->commit();
    fmt::print("\nResults: {}\n", options.json);
  }
}

/// An option of a bench: its name, which says what it sets (option_values), and its help.
struct OptionHelp {
  const char* name;
  std::string text;
};

constexpr std::pair<std::string_view, std::string Options::*> option_values[] = {
    {"--scene", &Options::scenes},  {"--kind", &Options::kinds},      {"--contestant", &Options::contestants},
    {"--sizes", &Options::sizes},   {"--threads", &Options::threads}, {"--steps", &Options::steps},
    {"--repeat", &Options::repeat}, {"--bodies", &Options::bodies},   {"--poses", &Options::poses}};

/// A bench as a command of the program.
struct Command {
  const char *name, *text;
  Bench bench;
  std::vector<OptionHelp> options;
  /// The names permitted for --scene, given those asked for.
  std::function<std::vector<std::string>(const Options&)> scenes = [](const Options&) { return builtin_names(); };
};

void add(CLI::App& program, const Command& command) {
  CLI::App* app = program.add_subcommand(command.name, command.text);
  const auto o = std::make_shared<Options>();
  app->add_option("--json", o->json, "write the results to this FILE");
  app->add_flag("--quick", o->quick, "fewer and shorter runs");
  for (const auto& [name, text] : command.options) {
    const auto value = std::ranges::find(option_values, std::string_view(name), [](const auto& v) { return v.first; });
    app->add_option(name, (*o).*(value->second), text);
  }
  app->callback([bench = command.bench, scenes = command.scenes, o] { run(bench, *o, scenes(*o)); });
}

std::vector<Command> step_benches() {
  const std::vector<OptionHelp> simulation{{"--scene", "built-in scenes, comma-separated"},
                                           {"--threads", "numbers of threads, comma-separated; default: the cores"},
                                           {"--steps", "simulation steps"},
                                           {"--repeat", "rounds a step"},
                                           {"--bodies", "bodies of each scene; default: the paper's number"}};
  return {{"scenes", "the paper's four scenes by executor", scenes_bench, simulation},
          {"figures", "the paper's Figures 3 to 7, measured and simulated", figures_bench, simulation},
          {"flowgraph", "overhead of the executors, and every executor on many loads", flowgraph_bench, simulation}};
}

std::vector<Command> kept_step_benches() {
  return {{"grains",
           "a bed of spheres of all sizes, beside a cell list and Bullet",
           grains_bench,
           {{"--sizes", "numbers of spheres, comma-separated; default: 20000,100000"},
            {"--threads", "tandem's numbers of threads, comma-separated; default: 1,2"},
            {"--steps", "steps before the first that is timed; default: 100"},
            {"--repeat", "stretches of six timed steps; default: 8"}}},
          {"steps",
           "steps with kept contacts: speed against error",
           steps_bench,
           {{"--scene", "built-in scenes, comma-separated"},
            {"--steps", "simulation steps; default: 400"},
            {"--bodies", "bodies of each scene; default: 400"}}},
          {"short-steps",
           "speedup of short steps by a second thread",
           short_steps_bench,
           {{"--scene", "built-in scenes, comma-separated"},
            {"--sizes", "numbers of bodies, comma-separated; default: 100,300,1000,3000"},
            {"--threads", "default: the cores"},
            {"--steps", "simulation steps; default: 400"},
            {"--repeat", "rounds a step"}}}};
}

std::vector<std::string> peers_scenes(const Options& options) {
  std::vector<std::string> allowed = peers_scene_names();
  for (const std::string& scene : split_list(options.scenes))
    if (std::filesystem::is_regular_file(scene)) allowed.push_back(scene);
  return allowed;
}

std::vector<Command> phase_benches() {
  const std::vector<std::string> worlds = broadphase_scenes();
  return {{"narrowphase",
           "speed against error, beside FCL, libccd and Bullet",
           narrowphase_bench,
           {{"--kind", "kinds of pairs, as box-box, comma-separated; default: all"},
            {"--poses", "queries of each kind and class; default: 400"},
            {"--repeat", "samples of each contestant's time; default: 15"}}},
          {"broadphase",
           "overlapping boxes, beside FCL, Embree, Bullet and CGAL where installed",
           broadphase_bench,
           {{"--scene", fmt::format("worlds of boxes, comma-separated: {}", fmt::join(worlds, ", "))},
            {"--sizes", "numbers of boxes, comma-separated"},
            {"--contestant", "contestants, comma-separated; default: all"},
            {"--threads", "numbers of threads, comma-separated; default: 1,2"},
            {"--steps", "steps after the first"}},
           [worlds](const Options&) { return worlds; }},
          {"peers",
           "the whole detection step, beside FCL's and Bullet's collision worlds",
           peers_bench,
           {{"--scene", fmt::format("scenes, comma-separated: {}, or files of 'tandem run --record'",
                                    fmt::join(peers_scene_names(), ", "))},
            {"--threads", "tandem's numbers of threads, comma-separated; default: 1,2"},
            {"--steps", "simulation steps; default: 400"},
            {"--bodies", "moving bodies of each scene; default: the paper's number"}},
           peers_scenes}};
}

std::vector<Command> query_benches() {
  return {{"planner",
           "robot arms among obstacles, beside FCL and Bullet",
           planner_bench,
           {{"--threads", "tandem's numbers of threads, comma-separated; default: 1,2"},
            {"--poses", "configurations of each world; default: 96000"}}},
          {"haptics",
           "a tool of 10,000 triangles against 500,000 at 1 kHz, beside FCL",
           haptics_bench,
           {{"--steps", "milliseconds; default: 20000"}}},
          {"vertex-impacts",
           "first impacts of vertices on straight lines, compared with exact ones",
           vertex_impacts_bench,
           {{"--poses", "queries of each kind; default: 40000"}}}};
}

std::vector<Command> mesh_benches() {
  return {{"cloth",
           "a folding sheet on a ball and on itself, beside FCL's updates",
           cloth_bench,
           {{"--sizes", "triangles of the sheet; default: 100000"}, {"--steps", "steps of the motion; default: 24"}}},
          {"round-meshes",
           "contacts of convex shapes with meshes of 6,000 triangles, beside FCL",
           round_meshes_bench,
           {{"--kind", "convex shapes, as cone, or rows, as 'cone deep', comma-separated, or just steps; default: all"},
            {"--poses", "poses of each pair of shapes and class; default: 40"},
            {"--bodies", "bodies of the steps; default: 1000"},
            {"--steps", "timed steps; default: 20"}}},
          {"depths",
           "bounds on the depth of solids deep in each other",
           depths_bench,
           {{"--kind", "families, comma-separated: bowls, rings, gears, tori, blobs; default: all"},
            {"--poses", "pairs of each family; default: 100"},
            {"--sizes", "boxes of translations, comma-separated; default: 200,1000,5000,20000,80000"}}},
          {"building",
           "building meshes for queries, beside Embree and FCL",
           building_bench,
           {{"--sizes", "numbers of triangles, comma-separated; default: 1000 to 5000000"},
            {"--repeat", "repetitions of each build; default: 15, for large ones 7 and 3"}}},
          {"big-meshes",
           "meshes by size, all requests, beside FCL, Embree and CGAL",
           big_meshes_bench,
           {{"--sizes", "numbers of triangles, comma-separated; default: 1000 to 5000000"},
            {"--contestant", "tandem, FCL, Embree, CGAL, comma-separated; default: all"},
            {"--repeat", "repetitions of each query; default: by size, 15 to 1"}}}};
}

std::vector<Command> adapter_benches() {
#ifdef TANDEM_HAS_FCL_ADAPTER
  return {{"fcl",
           "tandem::fcl's broad-phase manager beside FCL's managers",
           fcl_bench,
           {{"--sizes", "numbers of objects, comma-separated; default: 300,3000,30000"},
            {"--contestant", "managers, comma-separated: tandem, FCL tree, FCL SaP, FCL naive"},
            {"--steps", "simulation steps; default: 60"}}},
          {"octrees",
           "a robot's link among an octree's cells: FCL's octree, voxels, their mesh",
           octrees_bench,
           {{"--sizes", "about how many cells; default: 100000"}, {"--repeat", "rounds of each; default: 5"}}}};
#else
  return {};
#endif
}

void add_report(CLI::App& program) {
  struct ReportOptions {
    std::vector<std::string> files;
    std::string out, frames = "240";
  };
  CLI::App* app = program.add_subcommand("report", "results and recordings as one HTML page that opens offline");
  const auto o = std::make_shared<ReportOptions>();
  app->add_option("FILES", o->files,
                  "results of benches (--json), of tandem run: reports (--json), timelines (--trace), recordings "
                  "(--record)")
      ->type_name("");
  app->add_option("-o", o->out, "write the page to this FILE")->type_name("FILE");
  app->add_option("--frames", o->frames, "poses kept of a recording at most, 2 to 2000")
      ->type_name("N")
      ->capture_default_str();
  app->callback([o] {
    if (o->files.empty()) refuse_option("FILES", "", "results or recordings, at least one");
    if (o->out.empty()) refuse_option("-o", "", "the file to write");
    fmt::print("{}\n",
               write_report({o->files.begin(), o->files.end()}, o->out, whole_option("--frames", o->frames, 2, 2000)));
  });
}

int complain(std::string_view what, int status) {
  // The message lists all permitted values, here of the kinds of pairs: longer than messages about input.
  constexpr std::size_t most = 4 * limits::message_bytes;
  std::cerr << "tandem-bench: " << shortened(on_one_line(what), most) << '\n';
  return status;
}

int run_program(int count, char** arguments) {
  CLI::App program("Measures tandem: contestants in turn in one process, medians with spread, hashes beside times.",
                   "tandem-bench");
  program.set_version_flag("--version", "tandem-bench " TANDEM_VERSION);
  program.require_subcommand(1);
  for (const auto& benches :
       {step_benches(), phase_benches(), query_benches(), kept_step_benches(), mesh_benches(), adapter_benches()})
    for (const Command& command : benches) add(program, command);
  add_report(program);
  program.footer(
      "tandem-bench WHAT --help lists the options of WHAT.\nExit status: 0 done, 1 the work failed, 2 the request was "
      "wrong.");
  try {
    const std::string first = count > 1 ? arguments[1] : "";
    const auto commands = program.get_subcommands([](const CLI::App*) { return true; });
    if ((first.empty() || first[0] != '-') &&
        std::none_of(commands.begin(), commands.end(), [&](const auto* c) { return c->get_name() == first; })) {
      std::string names;
      for (const auto* command : commands) names += command->get_name() + ", ";
      refuse_option("WHAT", first, names + "--help");
    }
    program.parse(count, arguments);
  } catch (const CLI::Success& asked) {
    program.exit(asked);
  } catch (const CLI::ParseError& error) {
    refuse_option("command line", error.what(), "see --help");
  }
  return 0;
}

}  // namespace
}  // namespace tandem::bench

int main(int count, char** arguments) {
  using tandem::bench::complain;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that exceeds the limit then fails as on a full disk
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return tandem::bench::run_program(count, arguments);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), 2);
  } catch (const std::exception& error) {
    return complain(error.what(), 1);
  }
}
