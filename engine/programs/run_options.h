// What `tandem run` and `tandem-mpi run` are asked alike.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

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

}  // namespace tandem
