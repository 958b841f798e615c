// Writes the HTML page of a report.
#include "report.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <map>
#include <optional>
#include <stdexcept>

#include "accuracy.h"
#include "assets.h"
#include "broadphase/moving_boxes.h"
#include "encode.h"
#include "formats/output_file.h"
#include "inputs.h"
#include "progress.h"
#include "replay.h"
#include "results.h"
#include "workload.h"

namespace tandem::bench {
namespace {

constexpr std::size_t replay_bytes = 9'000'000;  // of all replays; base64 makes it 12 MB

std::string today() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts);
  return text;
}

/// The records for `tandem query`, by their id, of the worst inputs that the rows name. A row that holds the whole
/// record keeps it.
Json worst_records(const Json& results) {
  Json out = Json::object();
  for (const Json& result : results)
    for (const Json& row : result["rows"]) {
      const auto worst = row.find("worst");
      if (worst == row.end() || !worst->is_object() || !worst->contains("id") || !(*worst)["id"].is_string()) continue;
      const std::string id = (*worst)["id"];
      if (out.contains(id)) continue;
      if (worst->contains("shapeA"))
        out[id] = *worst;
      else if (const auto made = named_query_record(id, row.value("request", ""), row["n"]))
        out[id] = Json::parse(made->dump());
    }
  return out;
}

Json box_worlds() {
  Json out = Json::array();
  for (const BoxWorkload& world : box_workloads())
    out.push_back({{"name", world.name}, {"text", world.text}, {"breaking", world.breaking}});
  return out;
}

/// Inline text must not contain the end of its element.
std::string script(std::string_view text) {
  constexpr std::string_view end = "</script";
  std::string out = "<script>\n";
  for (std::size_t found; (found = text.find(end)) != std::string_view::npos; text.remove_prefix(found + end.size()))
    out.append(text.substr(0, found)).append("<\\/script");
  return out.append(text).append("\n</script>\n");
}

std::string data_block(std::string_view id, std::string_view bytes) {
  return fmt::format("<script type=\"application/octet-stream\" id=\"{}\">{}</script>\n", id, base64(bytes));
}

/// The import map by which modules find each other by name: a page opened from disk may not load files.
std::string import_map() {
  Json imports = Json::object();
  const auto add = [&](std::string_view name, std::string_view bytes) {
    imports[std::string(name)] = fmt::format("data:text/javascript;base64,{}", base64(bytes));
  };
  for (const Asset& file : assets())
    if (file.name.ends_with(".js") && file.name.find('/') == std::string_view::npos)
      add(fmt::format("report/{}", file.name), file.bytes);
  return fmt::format("<script type=\"importmap\">{}</script>\n", Json{{"imports", imports}}.dump());
}

std::string licences() {
  std::string out;
  for (const Asset& file : assets())
    if (file.name.ends_with("/copyright")) out += file.bytes;
  for (std::size_t at = 0; (at = out.find("--", at)) != std::string::npos;) out.erase(at, 1);  // "--" may end a comment
  return fmt::format("<!--\nThe libraries in this page and their licences.\n\n{}-->\n", out);
}

/// The text of the page with each mark <!-- NAME --> replaced.
std::string filled(std::string_view page, const std::map<std::string, std::string>& parts) {
  std::string out;
  for (std::size_t at = 0; at < page.size();) {
    const std::size_t begin = page.find("<!-- ", at), end = page.find(" -->", begin);
    if (begin == std::string_view::npos || end == std::string_view::npos) return out.append(page.substr(at));
    out.append(page.substr(at, begin - at));
    if (const auto part = parts.find(std::string(page.substr(begin + 5, end - begin - 5))); part != parts.end())
      out += part->second;
    at = end + 4;
  }
  return out;
}

}  // namespace

std::string write_report(const std::vector<std::filesystem::path>& files, const std::filesystem::path& out,
                         std::size_t most_frames) {
  if (!missing_libraries().empty()) throw std::runtime_error(fmt::format("report: {}", missing_libraries()));
  OutputFile page("-o", out);
  const Inputs inputs = read_inputs(files);
  Json data{{"version", TANDEM_VERSION},
            {"written", today()},
            {"machine", Json::parse(machine().dump())},
            {"results", inputs.results},
            {"runs", inputs.runs},
            {"timelines", inputs.timelines},
            {"replays", Json::array()},
            {"worst", worst_records(inputs.results)},
            {"worlds", box_worlds()}};
  std::string blocks;
  for (std::size_t i = 0; i < inputs.records.size(); ++i) {
    std::optional<Progress> progress;
    const Replay replay = read_replay(inputs.records[i], most_frames, replay_bytes / inputs.records.size(),
                                      [&](std::size_t done, std::size_t of) {
                                        if (!progress) progress.emplace("steps", of);
                                        progress->at(done);
                                      });
    data["replays"].push_back(Json::parse(replay.about.dump()));
    blocks += data_block(fmt::format("replay-{}-poses", i), replay.poses);
    blocks += data_block(fmt::format("replay-{}-contacts", i), replay.contacts);
    blocks += data_block(fmt::format("replay-{}-costs", i), replay.costs);
  }
  blocks += data_block("data", deflated(data.dump(-1, ' ', false, Json::error_handler_t::replace)));

  const std::string html =
      filled(asset("page.html"), {{"style", fmt::format("<style>\n{}</style>\n", asset("style.css"))},
                                  {"libraries", script(asset("d3/d3.min.js")) + script(asset("three/three.min.js")) +
                                                    script(asset("three/OrbitControls.js"))},
                                  {"modules", import_map()},
                                  {"data", blocks},
                                  {"licences", licences()}});
  page.append(html);
  page.commit();
  std::size_t rows = 0;
  for (const Json& result : inputs.results) rows += result["rows"].size();
  return fmt::format("{}: {:.1f} MB, {} rows, {} replays, {} timelines", out.string(),
                     1e-6 * static_cast<double>(html.size()), rows, inputs.records.size(), inputs.timelines.size());
}

}  // namespace tandem::bench
