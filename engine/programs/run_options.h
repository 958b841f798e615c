// What `tandem run` and `tandem-mpi run` are asked alike.
#pragma once
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/output_file.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/scene.h"

namespace tandem {

/// As typed; empty: not given.
struct RunOptions {
  std::string scene, steps = "300", bodies, seed, executor = "flowgraph", threads, broad_phase = "auto", request;
  std::string tolerance = "0", keep = "0", margin, json, contacts, trace, record;
  bool mesh_margin = false;
};

/// The help of those that are not quite the same.
struct RunTexts {
  const char *threads, *contacts, *trace, *record;
};

/// Adds an option whose value stays as typed.
void add_text(CLI::App& command, const char* option, const char* type, std::string& value, const char* text);

/// Adds the scene and all that is asked alike.
void add_run_options(CLI::App& command, RunOptions& options, const RunTexts& texts);

std::uint64_t steps_of(const RunOptions& options);

/// Sets what they say of how a step runs. Throws RequestError.
void read_run_options(const RunOptions& options, PipelineOptions& how);

/// The scene, with the request that was asked for; sets what of the answers depends on it.
Scene load_scene(const RunOptions& options, AnswerOptions& answer);

/// As many threads as were asked for, also where that is more than there are cores, as long as it lives.
tbb::global_control allowed_threads(int threads);

/// The files that are asked for, by option; no two may be one (require_different).
std::vector<std::pair<std::string_view, std::filesystem::path>> files_of(const RunOptions& options);

/// Files that both programs write: opened before the first step, they get their names when the last is done.
struct RunFiles {
  std::optional<OutputFile> json, contacts, trace;

  /// Those that are asked for.
  void open(const RunOptions& options);
};

}  // namespace tandem
