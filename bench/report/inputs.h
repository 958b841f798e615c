#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/json_reader.h"

namespace tandem::bench {

/// What a report is made of, checked; each element has a member `file`.
struct Inputs {
  Json results = Json::array();    ///< {file, machine, rows, ...} (docs/result-format.md); no rows beside pictures
  Json runs = Json::array();       ///< {file, steps}: what `tandem run --json` writes
  Json timelines = Json::array();  ///< {file, threads, recorded_steps, steps}
  std::vector<std::filesystem::path> records;
};

/// Reads files of four kinds, told apart by what is in them: a bench's results, step reports, a trace, a record (of
/// that only the beginning is looked at). Throws InputError "FILE: POINTER: FOUND, allowed: ALLOWED" or "FILE: byte N:
/// ..." for one that is missing, empty, cut off, of another version or of none of these kinds.
Inputs read_inputs(const std::vector<std::filesystem::path>& files);

}  // namespace tandem::bench
