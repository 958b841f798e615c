// The command `tandem query`.
#include <unistd.h>

#include <memory>

#include "commands.h"
#include "formats/pair_record.h"
#include "formats/text_file.h"
#include "option_text.h"
#include "progress.h"
#include "solver_list.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string file, solver, tolerance = "0", meshes;
  bool list_solvers = false, time = false;
};

std::vector<fs::path> mesh_folders(const Options& options) {
  std::vector<fs::path> folders;
  if (!options.meshes.empty()) {
    std::error_code ignored;
    if (!fs::is_directory(options.meshes, ignored)) refuse_option("--meshes", options.meshes, "a folder");
    folders.push_back(options.meshes);
  }
  if (const fs::path beside = fs::path(options.file).parent_path(); !beside.empty()) folders.push_back(beside);
  folders.push_back(".");
  return folders;
}

int answer_all(InputFile& in, const Options& options, const QueryOptions& query, DescriptorBuffer& out) {
  const bool live = options.file == "-";  // the writer of the records may be waiting for the answer
  ShapeReader shapes(mesh_folders(options));
  Progress progress("query", in.size().value_or(0));
  bool all_good = true;
  std::size_t others = 0;  // consecutive lines that are no records
  std::string line;
  for (std::size_t number = 1;; ++number) {
    const InputFile::Line found = in.line(line);
    if (found == InputFile::Line::none) return all_good ? 0 : 1;
    if (others++ == limits::lines_without_record) {
      out.flush();
      throw InputError(in.name() + ": line " + std::to_string(number), "no pair record in the lines before it",
                       "one in " + std::to_string(limits::lines_without_record));
    }
    if (found == InputFile::Line::read && line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const AnsweredLine answered =
        found == InputFile::Line::read
            ? answer_line(line, number, shapes, query)
            : bad_line({}, number, "a longer line, allowed: at most " + in_mebibytes(limits::stream_bytes));
    if (answered.is_record) others = 0;
    all_good = all_good && answered.ok;
    out.append(answered.text + '\n');
    if (live) out.flush();
    progress.at(std::min(in.position(), in.size().value_or(0)));
  }
}

std::unique_ptr<InputFile> open_records(const std::string& file) {
  try {
    return std::make_unique<InputFile>(file);
  } catch (const InputError& error) {
    throw error.within("FILE");
  }
}

int query(const Options& options, DescriptorBuffer& out) {
  QueryOptions query;
  query.narrow_phase.solver = options.solver;
  query.narrow_phase.tolerance = number_option("--tolerance", options.tolerance, 0, 0.1);
  query.time = options.time;
  if (!options.solver.empty()) {
    std::string names;
    bool known = false;
    for (const SolverInfo& solver : NarrowPhase::solvers()) {
      known = known || solver.name == options.solver;
      names += (names.empty() ? "" : ", ") + std::string(solver.name);
    }
    if (!known) refuse_option("--solver", options.solver, names);
  }
  const auto in = options.file == "-" ? std::make_unique<InputFile>(STDIN_FILENO, "stdin") : open_records(options.file);
  return answer_all(*in, options, query, out);
}

}  // namespace

void add_query_command(CLI::App& program, DescriptorBuffer& out, int& status) {
  CLI::App* command = program.add_subcommand("query", "answer pair records, one JSON object a line");
  const auto options = std::make_shared<Options>();
  command->add_option("FILE", options->file, "pair records; - is stdin")->type_name("");
  command->add_option("--solver", options->solver, "use this solver for all pairs that it can answer")
      ->type_name("NAME");
  command->add_flag("--list-solvers", options->list_solvers,
                    "list the solvers, and the one used for each two kinds of shapes");
  command->add_option("--tolerance", options->tolerance, "accepted error, relative to the bodies' size, 0 to 0.1")
      ->type_name("T")
      ->capture_default_str();
  command->add_flag("--time", options->time, "add the time per query in ns: the mean over 2 ms of repetitions");
  command
      ->add_option("--meshes", options->meshes,
                   "folder of mesh files; others are searched beside FILE, then in the working folder")
      ->type_name("DIR");
  command->footer(
      "A bad record is answered with its error and the next one is read.\n"
      "Exit status: 0 all answered, 1 a record was bad, 2 the request was wrong.");
  command->callback([options, &out, &status] {
    if (options->list_solvers) {
      out.append(solver_list());
      status = 0;
      return;
    }
    if (options->file.empty()) refuse_option("FILE", "", "a file of pair records, or -");
    status = query(*options, out);
  });
}

}  // namespace tandem
