// Options that `tandem run` and `tandem-mpi` have in common.
#include "run_options.h"

#include <oneapi/tbb/info.h>

#include <algorithm>

#include "formats/scene_json.h"
#include "option_text.h"
#include "scene_option.h"
#include "tandem/engine/response.h"

namespace tandem {

void add_text(CLI::App& command, const char* option, const char* type, std::string& value, const char* text) {
  command.add_option(option, value, text)->type_name(type)->capture_default_str();
}

void add_run_options(CLI::App& command, RunOptions& o, const RunTexts& texts) {
  command.add_option("SCENE", o.scene, "a built-in scene (tandem scenes) or a scene file")->type_name("");
  const auto add = [&](const char* option, const char* type, std::string& value, const char* text) {
    add_text(command, option, type, value, text);
  };
  add("--steps", "N", o.steps, "simulation steps");
  add("--bodies", "N", o.bodies, "bodies of a built-in scene; default: the paper's number");
  add("--seed", "N", o.seed, "seed of a built-in scene's random numbers; default 1");
  add("--executor", "NAME", o.executor, "sequential, barrier, fused, threads or flowgraph");
  add("--threads", "P", o.threads, texts.threads);
  add("--broadphase", "NAME", o.broad_phase, "brute, sweep, grid, bvh or auto");
  add("--request", "NAME", o.request, "collide, distance or contacts; default: the scene's");
  add("--tolerance", "T", o.tolerance, "accepted error, relative to the bodies' size, 0 to 0.1");
  add("--margin", "M", o.margin, "report pairs up to this distance as contacts of negative depth, metres");
  command.add_flag("--mesh-margin", o.mesh_margin,
                   "the margin counts between two meshes, too; steps of meshes take several times as long");
  add("--keep-contacts", "T", o.keep,
      "keep answers of pairs that moved less than this, relative to the bodies' size, 0 to 0.1; 0 computes all");
  add("--json", "FILE", o.json, "write a report of each step to this FILE");
  add("--contacts", "FILE", o.contacts, texts.contacts);
  add("--trace", "FILE", o.trace, texts.trace);
  add("--record", "FILE", o.record, texts.record);
}

std::uint64_t steps_of(const RunOptions& options) {
  if (options.scene.empty()) refuse_option("SCENE", "", "a built-in scene (tandem scenes) or a scene file");
  return whole_option("--steps", options.steps, 1, 1'000'000'000);
}

void read_run_options(const RunOptions& options, PipelineOptions& how) {
  constexpr BroadPhaseKind broad_phases[] = {BroadPhaseKind::brute, BroadPhaseKind::sweep, BroadPhaseKind::grid,
                                             BroadPhaseKind::bvh, BroadPhaseKind::automatic};
  how.executor = named_option("--executor", options.executor, executor_kinds);
  how.threads = static_cast<int>(whole_option("--threads", options.threads, 0, 1024));
  how.broad_phase = named_option("--broadphase", options.broad_phase, broad_phases);
  how.answer.tolerance = number_option("--tolerance", options.tolerance, 0, 0.1);
  how.answer.keep_contacts = number_option("--keep-contacts", options.keep, 0, 0.1);
  how.answer.contact_hash = true;
  how.answer.mesh_margin = options.mesh_margin;
  if (!options.margin.empty()) how.answer.margin = number_option("--margin", options.margin, 0, 1e6);
}

Scene load_scene(const RunOptions& options, AnswerOptions& answer) {
  std::optional<Request> request;
  if (!options.request.empty()) request = named_option("--request", options.request, requests);
  Scene scene = load_scene(options.scene, options.bodies, options.seed);
  if (request) scene.request = *request;
  answer.request = scene.request;
  const bool contacts = scene.request == Request::contacts;
  // A response needs contacts of negative depth to stop bodies in time; they are written only where they were asked
  // for.
  if (options.margin.empty() && contacts) answer.margin = recommended_margin(scene);
  if (!options.contacts.empty() && !contacts)
    refuse_option("--contacts", options.contacts,
                  "with the request 'contacts'; this one is '" + std::string(name(scene.request)) + "'");
  return scene;
}

tbb::global_control allowed_threads(int threads) {
  const int most = std::max(threads, tbb::info::default_concurrency());
  return {tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(most)};
}

std::vector<std::pair<std::string_view, std::filesystem::path>> files_of(const RunOptions& options) {
  return {{"SCENE", options.scene},
          {"--json", options.json},
          {"--contacts", options.contacts},
          {"--trace", options.trace},
          {"--record", options.record}};
}

void RunFiles::open(const RunOptions& options) {
  if (!options.json.empty()) json.emplace("--json", options.json);
  if (!options.contacts.empty()) contacts.emplace("--contacts", options.contacts);
  if (!options.trace.empty()) trace.emplace("--trace", options.trace);
}

}  // namespace tandem
