// The inputs of a report.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/json_reader.h"

namespace tandem::bench {

/// The checked inputs of a report; each element has a member `file`.
struct Inputs {
  /// {file, machine, rows, ...} (docs/result-format.md); without rows if there are pictures.
  Json results = Json::array();
  Json runs = Json::array();       ///< {file, steps}: the output of `tandem run --json`
  Json timelines = Json::array();  ///< {file, threads, recorded_steps, steps}
  std::vector<std::filesystem::path> records;
};

/// Reads files of four kinds, told apart by their contents: results of a bench, step reports, a timeline, a recording
/// (only its beginning). Throws InputError "FILE: POINTER: FOUND, allowed: ALLOWED" or "FILE: byte N: ..." for a file
/// that is missing, empty, truncated, of another version or of none of these kinds.
Inputs read_inputs(const std::vector<std::filesystem::path>& files);

}  // namespace tandem::bench
