// The command `tandem clash`.
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>

#include "clash/clash.h"
#include "clash/journal.h"
#include "clash/page.h"
#include "commands.h"
#include "formats/input_limits.h"
#include "formats/text_file.h"
#include "option_text.h"
#include "progress.h"
#include "tandem/formats/mesh_file.h"

namespace tandem {
namespace {

using clash::Clash;
using clash::Part;

struct Options {
  std::vector<std::string> files;
  std::string clearance = "0", report, resume, threads = "0";
  bool json = false;
};

// The files given, with folders replaced by the mesh files in them, by name.
std::vector<std::filesystem::path> listed(const std::vector<std::string>& given) {
  std::vector<std::filesystem::path> out;
  for (const std::string& name : given) {
    std::error_code error;
    if (!std::filesystem::is_directory(name, error)) {
      if (!std::filesystem::exists(name, error))
        throw RequestError("FILES: there is no file or folder '" + name + "'" + (error ? ": " + error.message() : ""));
      out.emplace_back(name);
      continue;
    }
    std::vector<std::filesystem::path> inside;
    for (std::filesystem::directory_iterator at(name, error), end; !error && at != end; at.increment(error))
      if (is_mesh_file(at->path())) {
        const InputFile must_be_regular(at->path(), InputFile::Kind::regular);
        inside.push_back(at->path());
      }
    if (error) throw RequestError("FILES: '" + name + "': " + error.message() + ", allowed: a folder that can be read");
    if (inside.empty())
      throw RequestError("FILES: '" + name + "' has no mesh file, allowed: " + std::string(mesh_extensions));
    std::sort(inside.begin(), inside.end());
    out.insert(out.end(), inside.begin(), inside.end());
  }
  if (out.size() < 2)
    refuse_option("FILES", std::to_string(out.size()) + (out.size() == 1 ? " file" : " files"),
                  "at least two, or a folder of them");
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (out[i] == out[j]) throw RequestError("FILES: '" + out[i].string() + "' twice, allowed: once");
  return out;
}

std::vector<Clash> found(const std::vector<Part>& parts, double clearance, const std::string& resume) {
  std::optional<clash::Journal> journal;
  if (!resume.empty()) journal.emplace(resume, parts, clearance);
  std::vector<Clash> out;
  std::vector<clash::Pair> left;
  for (const clash::Pair& pair : clash::candidates(parts, clearance)) {
    const auto known = journal ? journal->answers().find({pair.a, pair.b}) : decltype(journal->answers().end()){};
    if (!journal || known == journal->answers().end()) {
      left.push_back(pair);
    } else if (known->second.near) {
      out.push_back(known->second.clash);
    }
  }
  Progress progress("pairs", left.size());
  std::size_t done = 0;
  clash::answer_all(parts, left, clearance, [&](const clash::Pair& pair, const clash::Answer& answer) {
    if (journal) journal->add(pair, answer);
    if (answer.near) out.push_back(answer.clash);
    progress.at(++done);
  });
  std::sort(out.begin(), out.end(), [](const Clash& x, const Clash& y) {
    return x.distance != y.distance ? x.distance < y.distance : x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  return out;
}

// File names where they are unique, else whole paths.
std::vector<std::string> short_names(const std::vector<Part>& parts) {
  std::vector<std::string> names, sorted;
  for (const Part& part : parts) names.push_back(std::filesystem::path(part.file).filename().string());
  sorted = names;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) return names;
  for (std::size_t i = 0; i < parts.size(); ++i) names[i] = parts[i].file;
  return names;
}

// Left-aligned columns, two spaces between.
std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  std::string out;
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k)
      out += k + 1 < row.size() ? row[k] + std::string(widths[k] + 2 - row[k].size(), ' ') : row[k] + '\n';
  return out;
}

std::string clash_rows(const std::vector<std::string>& names, const std::vector<Clash>& clashes) {
  std::vector<std::vector<std::string>> rows = {
      {"part", "part", "depth or gap", "triangle pairs", "places", "deepest"}};
  for (const Clash& c : clashes) {
    std::ostringstream size, place;
    size << (c.status == Status::ok ? "" : "~") << std::abs(c.distance) << (c.intersects ? " deep" : " apart");
    place << c.place.x() << ' ' << c.place.y() << ' ' << c.place.z();
    const bool inside = c.intersects && c.triangle_pairs == 0;
    rows.push_back({names[c.a], names[c.b], size.str(), inside ? "inside" : std::to_string(c.triangle_pairs),
                    c.zone_count > 0 ? std::to_string(c.zone_count) : "", place.str()});
  }
  return aligned(rows);
}

std::string table(const std::vector<Part>& parts, const std::vector<Clash>& clashes, double clearance) {
  const std::vector<std::string> names = short_names(parts);
  std::size_t triangles = 0, memory = 0;
  for (const Part& part : parts) {
    triangles += part.shape.triangles().size();
    memory += part.shape.memory();
  }
  const auto hits = std::count_if(clashes.begin(), clashes.end(), [](const Clash& c) { return c.intersects; });
  const bool unproven =
      std::any_of(clashes.begin(), clashes.end(), [](const Clash& c) { return c.status != Status::ok; });
  std::ostringstream out;
  if (!clashes.empty()) out << clash_rows(names, clashes);
  out << hits << " of " << parts.size() * (parts.size() - 1) / 2 << " pairs of " << parts.size() << " parts intersect";
  if (clearance > 0)
    out << ", " << clashes.size() - static_cast<std::size_t>(hits) << " more are at most " << clearance << " apart";
  out << "; " << triangles << " triangles in " << (memory + limits::mebibyte - 1) / limits::mebibyte << " MiB\n";
  if (unproven) out << "~: not exact; --json tells the error's bound, error_bound. That they intersect is exact\n";
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (!parts[i].open.empty())
      out << names[i] << ": a surface, whose inside does not count: " << parts[i].open << '\n';
  return out.str();
}

int run(const Options& options, DescriptorBuffer& out) {
  const double clearance = number_option("--clearance", options.clearance, 0, std::numeric_limits<double>::max());
  const auto threads = static_cast<int>(whole_option("--threads", options.threads, 0, 1024));
  const auto files = listed(options.files);
  std::vector<std::pair<std::string_view, std::filesystem::path>> different = {{"--report", options.report},
                                                                               {"--resume", options.resume}};
  for (const auto& file : files) different.emplace_back("FILES", file);
  require_different(different);
  std::optional<OutputFile> report;
  if (!options.report.empty()) report.emplace("--report", options.report);

  std::optional<tbb::global_control> limit;
  if (threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  std::vector<Part> parts;
  std::vector<Clash> clashes;
  arena.execute([&] {
    {
      Progress progress("files", files.size());
      parts = clash::read_parts(files, [&](std::size_t done) { progress.at(done); });
    }
    clashes = found(parts, clearance, options.resume);
  });
  if (options.json) {
    for (const Clash& clash : clashes) {
      JsonWriter line;
      write(line, parts, clash);
      out.append(line.text() + '\n');
    }
  } else {
    out.append(table(parts, clashes, clearance));
  }
  if (report) {
    report->append(clash::page(parts, clashes, clearance));
    report->commit();
  }
  return 0;
}

}  // namespace

void add_clash_command(CLI::App& program, DescriptorBuffer& out, int& status) {
  CLI::App* command = program.add_subcommand("clash", "find mesh files that intersect or are too near each other");
  const auto options = std::make_shared<Options>();
  command
      ->add_option("FILES", options->files,
                   "mesh files (" + std::string(mesh_extensions) + ") in one frame and unit, or folders of them")
      ->type_name("");
  command
      ->add_option("--clearance", options->clearance,
                   "also report pairs that are at most this far apart, in the files' unit")
      ->type_name("C")
      ->capture_default_str();
  command->add_flag("--json", options->json, "print a JSON object a line instead of the table");
  command->add_option("--report", options->report, "write an HTML page that shows the clashes to this FILE")
      ->type_name("FILE");
  command->add_option("--resume", options->resume, "keep answers in this FILE, and continue from those in it")
      ->type_name("FILE");
  command->add_option("--threads", options->threads, "threads in all, 0 to 1024; 0 asks the runtime")
      ->type_name("P")
      ->capture_default_str();
  command->footer(
      "All pairs of parts, on all cores. A closed mesh is a solid: a part inside it intersects. Meshes stay in memory, "
      "some\n"
      "200 bytes a triangle. Of files that are not moved to their place in the whole, nothing can be said.\n"
      "Exit status: 0 done, 1 the work failed, 2 the request was wrong.");
  command->callback([options, &out, &status] { status = run(*options, out); });
}

}  // namespace tandem
