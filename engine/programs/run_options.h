// Options that `tandem run` and `tandem-mpi run` have in common.
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

/// The options as typed; empty: not given.
struct RunOptions {
  std::string scene, steps = "300", bodies, seed, executor = "flowgraph", threads, broad_phase = "auto", request;
  std::string tolerance = "0", keep = "0", margin, json, contacts, trace, record;
  bool mesh_margin = false;
};

/// Help texts of the options that differ.
struct RunTexts {
  const char *threads, *contacts, *trace, *record;
};

/// Adds an option whose value is kept as typed.
void add_text(CLI::App& command, const char* option, const char* type, std::string& value, const char* text);

/// Adds the scene and all common options.
void add_run_options(CLI::App& command, RunOptions& options, const RunTexts& texts);

std::uint64_t steps_of(const RunOptions& options);

/// Sets how a step runs. Throws RequestError.
void read_run_options(const RunOptions& options, PipelineOptions& how);

/// Loads the scene, with the requested request; sets the answer options that depend on it.
Scene load_scene(const RunOptions& options, AnswerOptions& answer);

/// Permits as many threads as were asked for while it lives, even more than there are cores.
tbb::global_control allowed_threads(int threads);

/// The requested files, by option; no two may be the same (require_different).
std::vector<std::pair<std::string_view, std::filesystem::path>> files_of(const RunOptions& options);

/// Files that both programs write: opened before the first step, renamed to their names at the end.
struct RunFiles {
  std::optional<OutputFile> json, contacts, trace;

  /// Opens the requested files.
  void open(const RunOptions& options);
};

}  // namespace tandem
