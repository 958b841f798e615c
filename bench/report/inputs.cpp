// Reads and checks the files that a report shows.
#include "inputs.h"

#include <algorithm>
#include <string_view>

#include "formats/text_file.h"
#include "gzip.h"
#include "results.h"
#include "trace_steps.h"

namespace tandem::bench {
namespace {

constexpr std::string_view kinds = "a result of tandem-bench, or of tandem run what --json, --trace or --record wrote";

void require_count(const JsonRef& object, std::string_view key) { object.at(key).number_at_least(0); }

/// Checks the curves of figures, docs/result-format.md.
void check_pictures(const JsonRef& pictures) {
  pictures.require_array("an array of pictures");
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const JsonRef picture = pictures.at(i);
    picture.at("workload").text();
    picture.at("simulated").flag();
    require_count(picture, "threads");
    if (const auto series = picture.find("series"))
      series->require_array("an array of series");
    else
      picture.at("ms").require_array("an array of times");
  }
}

Json checked_results(const JsonRef& document, const std::string& file) {
  if (const auto version = document.find("version"); version && version->whole(0xffffffffu) != results_version)
    version->refuse(std::to_string(results_version));
  const JsonRef machine = document.at("machine");
  if (!machine.value().is_object()) machine.refuse("an object");
  const JsonRef rows = document.at("rows");
  rows.require_array("an array of rows");
  if (rows.size() == 0) rows.refuse("at least one row");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const JsonRef row = rows.at(i);
    for (const char* key : {"bench", "workload", "contestant"}) row.at(key).text();
    for (const char* key : {"threads", "n"}) row.at(key).whole(0xffffffffu);
    for (const char* key : {"median_ns", "p10_ns", "p90_ns"}) require_count(row, key);
    if (const auto request = row.find("request")) request->text();
  }
  Json out = document.value();
  out["file"] = file;
  // The curves hold the same as a row a step, in less space.
  if (const auto pictures = document.find("pictures")) check_pictures(*pictures), out.erase("rows");
  if (!out.contains("rows")) out["rows"] = Json::array();
  return out;
}

Json checked_step(const JsonRef& step) {
  for (const char* key : {"step", "candidate_pairs", "colliding_pairs", "contacts"}) require_count(step, key);
  for (const char* key : {"contact_hash", "split"}) step.at(key).text();
  const JsonRef ms = step.at("ms");
  for (const char* key : {"update", "broad", "narrow", "detect", "response", "step"}) require_count(ms, key);
  return step.value();
}

/// Reads the output of `tandem run --json`, one JSON object a line.
Json checked_run(std::string_view text, const std::string& file) {
  Json steps = Json::array();
  std::size_t values_left = limits::json_values;  // for all lines together
  for (std::size_t begin = 0, line = 1; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    try {
      const Json json = parse_json(text.substr(begin, end - begin), nullptr, &values_left);
      steps.push_back(checked_step(JsonRef(json)));
    } catch (const InputError& error) {
      throw error.within("line " + std::to_string(line));
    }
    begin = end + 1;
  }
  return {{"file", file}, {"steps", std::move(steps)}};
}

// Names the kind of a file that a report cannot show, by its beginning; empty if unknown.
std::string_view other_kind(std::string_view text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  const auto has = [&](std::string_view part) { return text.substr(0, 4096).find(part) != std::string_view::npos; };
  if (has(std::string_view("\0", 1))) return "a binary file";
  if (line.starts_with("{\"step\":") && line.find("\"contacts\":[") != std::string_view::npos)
    return "what --contacts wrote";
  if (has("\"shapeA\"")) return "pair records";
  if (has("\"shapes\"") && has("\"gravity\"")) return "a scene file";
  if (text.find_first_of("{[") != text.find_first_not_of(" \t\r\n")) return "no JSON";
  return {};
}

void add(Inputs& inputs, const std::string& text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) throw InputError({}, "empty", kinds);
  if (const std::string_view other = other_kind(text); !other.empty()) throw InputError({}, other, kinds);
  if (text.starts_with("{\"step\":")) {
    inputs.runs.push_back(checked_run(text, file));
    return;
  }
  const Json json = parse_json(text);
  const JsonRef document(json);
  if (document.find("traceEvents"))
    inputs.timelines.push_back(trace_steps(document, file));
  else if (document.find("machine") || document.find("rows"))
    inputs.results.push_back(checked_results(document, file));
  else
    document.refuse(kinds);
}

}  // namespace

Inputs read_inputs(const std::vector<std::filesystem::path>& files) {
  Inputs inputs;
  for (const std::filesystem::path& path : files) {
    InputFile in(path);
    constexpr std::string_view record = R"({"format":"tandem-record")";
    if (in.peek(record.size()) == record) {
      if (!in.size()) throw InputError(in.name(), "a recording in a pipe", "one in a file, as it is read twice");
      inputs.records.push_back(path);
      continue;
    }
    std::string text = in.rest(limits::document_bytes);
    try {
      if (is_gzipped(text)) text = gunzipped(text, limits::document_bytes);
      add(inputs, text, in.name());
    } catch (const InputError& error) {
      throw error.within(in.name());
    }
  }
  return inputs;
}

}  // namespace tandem::bench
