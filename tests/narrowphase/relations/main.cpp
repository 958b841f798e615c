// The program `relations`: metamorphic tests of the narrow phase on random pairs or on records. Prints failures as
// minimal records for `tandem query`, and counts them by relation and kinds. The exit status is 1 if any relation
// fails, and 3 if none did but the run was stopped.
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "draw.h"
#include "formats/pair_record.h"
#include "relations.h"
#include "tandem/formats/mesh_file.h"

namespace {

using namespace tandem;
using namespace tandem::relations;

constexpr std::size_t most_relations = 48;

constexpr int interrupted = 3;  // exit status of a run that was stopped, unless a relation failed

constexpr double default_margin = 0.1;  // metres, for records without one

struct Options {
  std::uint64_t seed = 1, pairs = 10000;
  std::vector<std::string> only{};
  std::string a, b, meshes, records;
  std::size_t largest_mesh = 4000;  // triangles
  std::size_t show = 1;             // failures printed for a relation and two kinds
  bool needles = false;             // A is a sliver or a long thin hull, B much smaller
  bool rounded = false;             // one or both shapes are rounded
  bool unusual = false;             // rare constructions (unusual.h)
  bool deep = false;                // B about the middle of A
  bool settled = false;             // B at rest against A
  bool slivers = false;             // B on the face of a sliver
  bool raw = false;                 // without minimisation
  bool list = false;                // prints the pairs without checking them
  bool table = false;               // counts by kinds and relation, too
  int threads = 0;                  // 0: one per core
};

std::optional<ShapeKind> kind_of(const std::string& word) {
  if (word.empty()) return std::nullopt;
  for (std::size_t k = 0; k < shape_kinds; ++k)
    if (name(static_cast<ShapeKind>(k)) == word) return static_cast<ShapeKind>(k);
  throw std::invalid_argument("no kind of shape is called " + word);
}

std::vector<NamedMesh> read_meshes(const std::string& folder, std::size_t largest) {
  std::vector<NamedMesh> all;
  if (folder.empty()) return all;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (is_mesh_file(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    Mesh mesh = read_mesh_file(file.string());
    if (mesh.triangles.size() > largest) continue;
    try {
      mesh.solid = true;
      Shape closed(mesh);
    } catch (const std::invalid_argument&) {
      mesh.solid = false;
    }
    double size = 0;
    for (const Vec3& v : mesh.vertices) size = std::max(size, v.norm());
    for (Vec3& v : mesh.vertices) v /= size;
    all.push_back({file.filename().string(), std::move(mesh)});
  }
  return all;
}

// A pair and the relations that it contradicts.
struct Judged {
  std::string id;
  PosedPair pair;
  bool inexact_distance = false, inexact_contacts = false;
  std::array<bool, most_relations> asked{}, failed{};
};

std::string name_of(const PosedShape& s) {
  return std::string(s.rounding > 0 ? "rounded " : "").append(name(s.kind()));
}

std::string kinds_of(const PosedPair& pair) {
  std::array kinds{name_of(pair.a), name_of(pair.b)};
  std::sort(kinds.begin(), kinds.end());
  return kinds[0] + "-" + kinds[1];
}

Judged judge(const Options& options, const std::string& id, const PosedPair& pair) {
  Judged judged{id, pair};
  const Shape a = make_shape(pair.a), b = make_shape(pair.b);
  const Answers answers = answer(a, pair.a.pose, b, pair.b.pose, pair.margin);
  judged.inexact_distance = answers.distance.status == Status::inexact;
  judged.inexact_contacts = !answers.touching.empty() && answers.contacts.status == Status::inexact;
  for (std::size_t k = 0; k < relations::relations().size(); ++k) {
    const Relation& relation = relations::relations()[k];
    judged.asked[k] = relation.covers(pair) &&
                      (options.only.empty() ||
                       std::find(options.only.begin(), options.only.end(), relation.name) != options.only.end());
    if (!judged.asked[k]) continue;
    Random random(pair.seed);
    judged.failed[k] = !relation.check({pair, a, b, answers, unit_of(pair)}, random).empty();
  }
  return judged;
}

class Tally {
 public:
  explicit Tally(const Options& options) : options_(options) {}

  void add(const Judged& judged) {
    Row& row = rows_[kinds_of(judged.pair)];
    row.inexact_distances += judged.inexact_distance ? 1 : 0;
    row.inexact_contacts += judged.inexact_contacts ? 1 : 0;
    ++row.pairs;
    for (std::size_t k = 0; k < most_relations; ++k) {
      row.asked[k] += judged.asked[k] ? 1 : 0;
      if (judged.failed[k] && ++row.failures[k] <= options_.show) show(relations::relations()[k], judged);
    }
  }

  // Returns 1 if any relation failed.
  int finish() const {
    if (options_.table) print_table();
    Row all;
    for (const auto& [kinds, row] : rows_) all += row;
    std::printf("%-18s %10s %9s\n", "relation", "pairs", "failures");
    for (std::size_t k = 0; k < relations::relations().size(); ++k) {
      if (all.asked[k] == 0) continue;
      std::printf("%-18s %10" PRIu64 " %9" PRIu64, std::string(relations::relations()[k].name).c_str(), all.asked[k],
                  all.failures[k]);
      for (const auto& [kinds, row] : rows_)
        if (row.failures[k] > 0) std::printf("  %s %" PRIu64 "/%" PRIu64, kinds.c_str(), row.failures[k], row.asked[k]);
      std::printf("\n");
    }
    std::printf("%" PRIu64 " pairs, %" PRIu64 " failures; inexact: %" PRIu64 " distances, %" PRIu64
                " deepest contacts\n",
                all.pairs, all.all_failures(), all.inexact_distances, all.inexact_contacts);
    return all.all_failures() > 0 ? 1 : 0;
  }

 private:
  // The counts of a pair of kinds.
  struct Row {
    std::uint64_t pairs = 0, inexact_distances = 0, inexact_contacts = 0;
    std::array<std::uint64_t, most_relations> asked{}, failures{};  // by relation

    std::uint64_t all_failures() const { return std::accumulate(failures.begin(), failures.end(), std::uint64_t{0}); }
    Row& operator+=(const Row& r) {
      pairs += r.pairs;
      inexact_distances += r.inexact_distances;
      inexact_contacts += r.inexact_contacts;
      for (std::size_t k = 0; k < most_relations; ++k) asked[k] += r.asked[k], failures[k] += r.failures[k];
      return *this;
    }
  };

  void show(const Relation& relation, const Judged& judged) const {
    const PosedPair shown = options_.raw ? judged.pair : minimal(relation, judged.pair);
    std::printf("%s %s (%s): %s\n", std::string(relation.name).c_str(), judged.id.c_str(),
                kinds_of(judged.pair).c_str(), check(relation, shown).c_str());
    std::printf("%s\n", record(shown, std::string(relation.name) + "-" + judged.id).c_str());
    std::fflush(stdout);
  }

  // Prints a Markdown table: a row for each pair of kinds, a column for each relation; empty where the relation does
  // not apply.
  void print_table() const {
    std::printf("| kinds | pairs | inexact |");
    const auto& all = relations::relations();
    for (const Relation& r : all) std::printf(" %s |", std::string(r.name).c_str());
    std::printf("\n|---|--:|--:|");
    for (std::size_t k = 0; k < all.size(); ++k) std::printf("--:|");
    for (const auto& [kinds, row] : rows_) {
      std::printf("\n| %s | %" PRIu64 " | %" PRIu64 " |", kinds.c_str(), row.pairs, row.inexact_distances);
      for (std::size_t k = 0; k < all.size(); ++k)
        std::printf(" %s |", row.asked[k] > 0 ? std::to_string(row.failures[k]).c_str() : "");
    }
    std::printf("\n\n");
  }

  const Options& options_;
  std::map<std::string, Row> rows_;
};

// A pair that is built where it is checked.
struct Draft {
  std::string id;
  std::function<PosedPair()> make;
};

// Returns the next pair, or null.
using Source = std::function<std::shared_ptr<Draft>()>;

// Set by an interrupt or the end of `timeout`: pairs in work are judged, and the counts are printed.
std::atomic<bool> stopped = false;
static_assert(std::atomic<bool>::is_always_lock_free);

// Checks pairs on several threads; counts and prints in the order of the pairs.
int run(const Options& options, const Source& source) {
  using Made = std::shared_ptr<Draft>;
  using Done = std::shared_ptr<Judged>;
  Tally tally(options);
  const auto next = [&](tbb::flow_control& flow) {
    Made draft = stopped ? nullptr : source();
    if (draft == nullptr) flow.stop();
    return draft;
  };
  const auto answer = [&](const Made& draft) {
    return std::make_shared<Judged>(judge(options, draft->id, draft->make()));
  };
  const auto count = [&](const Done& judged) { tally.add(*judged); };
  constexpr std::size_t ahead = 16;  // pairs in work per thread: one may take as long as a hundred others
  const int cores = tbb::this_task_arena::max_concurrency();
  const int threads = options.threads > 0 ? std::min(options.threads, cores) : cores;
  tbb::task_arena(threads).execute([&] {
    tbb::parallel_pipeline(ahead * static_cast<std::size_t>(threads),
                           tbb::make_filter<void, Made>(tbb::filter_mode::serial_in_order, next) &
                               tbb::make_filter<Made, Done>(tbb::filter_mode::parallel, answer) &
                               tbb::make_filter<Done, void>(tbb::filter_mode::serial_in_order, count));
  });
  const int failed = tally.finish();
  if (!stopped) return failed;
  std::printf("stopped\n");
  return failed != 0 ? failed : interrupted;
}

PosedShape posed(const PlacedShape& s) { return {data_of(s.shape), s.pose, s.shape.rounding()}; }

int run_records(const Options& options) {
  std::ifstream file(options.records);
  if (!file) throw std::invalid_argument("cannot read " + options.records);
  ShapeReader shapes({std::filesystem::path(options.records).parent_path()});
  return run(options, [&]() -> std::shared_ptr<Draft> {
    for (std::string line; std::getline(file, line);) {
      const PairRecord r = read_pair_record(Json::parse(line), shapes);
      if (!r.a.shape.is_bounded() && !r.b.shape.is_bounded()) continue;
      const PosedPair pair{posed(r.a), posed(r.b), r.margin > 0 ? r.margin : default_margin, options.seed};
      return std::make_shared<Draft>(Draft{r.id.dump(), [pair] { return pair; }});
    }
    return nullptr;
  });
}

int run_random(const Options& options) {
  const DrawOptions draw{kind_of(options.a), kind_of(options.b), read_meshes(options.meshes, options.largest_mesh),
                         options.needles,    options.rounded,    options.unusual,
                         options.deep,       options.settled,    options.slivers};
  if (options.list) {
    for (std::uint64_t seed = options.seed; seed < options.seed + options.pairs; ++seed)
      std::puts(record(draw_pair(seed, draw), std::to_string(seed)).c_str());
    return 0;
  }
  std::uint64_t drawn = 0;
  return run(options, [&]() -> std::shared_ptr<Draft> {
    if (drawn == options.pairs) return nullptr;
    const std::uint64_t seed = options.seed + drawn++;
    return std::make_shared<Draft>(Draft{std::to_string(seed), [&draw, seed] { return draw_pair(seed, draw); }});
  });
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::string list = "Relations:";
  for (const Relation& r : relations::relations()) list += "\n  " + std::string(r.name) + ": " + std::string(r.says);
  CLI::App app{"Checks relations between answers of the narrow phase, on random pairs or on records.\n" + list};
  app.add_option("--seed", options.seed, "seed of the first pair; the next pair has the next number");
  app.add_option("--pairs", options.pairs, "number of pairs");
  app.add_option("--relation", options.only, "only these relations, comma-separated")->delimiter(',');
  CLI::Option* const kind_of_a = app.add_option("--a", options.a, "kind of A, else any");
  app.add_option("--b", options.b, "kind of B, else any");
  app.add_option("--meshes", options.meshes, "folder of .obj and .stl files from which meshes are drawn, too");
  app.add_option("--largest-mesh", options.largest_mesh, "most triangles of such a mesh");
  app.add_option("--records", options.records, "judge the pair records of this file instead");
  app.add_option("--show", options.show, "failures printed for a relation and two kinds");
  app.add_flag("--needles", options.needles, "A is a sliver or a long thin hull, B 1e3 to 1e8 times smaller")
      ->excludes(kind_of_a);
  app.add_flag("--rounded", options.rounded, "only pairs of which one or both have rounding");
  app.add_flag(
      "--unusual", options.unusual,
      "only triangles given twice, hulls of thousands of points, stacks, one in another, thin walls, shapes far "
      "from their own origin, one shape twice, exact touches turned");
  app.add_flag("--deep", options.deep, "B, often much smaller, is about the middle of A");
  app.add_flag("--settled", options.settled,
               "B rests against A, often a solid with corners, or is sunk into it a little");
  app.add_flag("--slivers", options.slivers,
               "A is a sliver, as triangle, hull, thin tetrahedron or mesh; B is set on its face")
      ->excludes(kind_of_a);
  app.add_option("--threads", options.threads, "number of threads, 0: one for each core; results do not depend on it")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--table", options.table, "also print failures by kinds and relation as a Markdown table");
  app.add_flag("--list", options.list, "print the pairs of the seeds as records, and judge none");
  app.add_flag("--raw", options.raw, "print failing pairs as they were drawn, not minimal ones");
  CLI11_PARSE(app, argc, argv);
  // `timeout` sends each twice: to the program and to its group. SIGQUIT ends the program at once.
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopped = true; });
  try {
    return options.records.empty() ? run_random(options) : run_records(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "relations: %s\n", error.what());
    return 2;
  }
}
