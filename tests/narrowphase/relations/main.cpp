// Holds answers of the narrow phase against each other, on random pairs or on records. Prints what fails as minimal
// records for `tandem query`, and counts by relation and kinds. 1 if any relation fails.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
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

struct Count {
  std::uint64_t pairs = 0, failures = 0;
};

constexpr double default_margin = 0.1;  // metres, of records without

struct Options {
  std::uint64_t seed = 1, pairs = 10000;
  std::vector<std::string> only{};
  std::string a, b, meshes, records;
  std::size_t largest_mesh = 4000;  // triangles
  std::size_t show = 1;             // failures printed for a relation and two kinds
  bool needles = false;             // A a sliver or a long thin hull, B much smaller
  bool raw = false;                 // as they are drawn
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

class Tally {
 public:
  explicit Tally(const Options& options) : options_(options) {}

  void judge(const PosedPair& pair, const std::string& id) {
    const Shape a = make_shape(pair.a.shape), b = make_shape(pair.b.shape);
    const Answers answers = answer(pair);
    std::array kinds{name(a.kind()), name(b.kind())};
    if (kinds[1] < kinds[0]) std::swap(kinds[0], kinds[1]);
    if (answers.distance.status == Status::inexact) ++inexact_;
    if (!answers.touching.empty() && answers.contacts.status == Status::inexact) ++inexact_contacts_;
    for (const Relation& relation : relations::relations()) {
      if (!options_.only.empty() &&
          std::find(options_.only.begin(), options_.only.end(), relation.name) == options_.only.end())
        continue;
      Count& count = counts_[{std::string(relation.name), std::string(kinds[0]).append("-").append(kinds[1])}];
      ++count.pairs;
      Random random(pair.seed);
      const std::string why = relation.check({pair, a, b, answers, unit_of(pair)}, random);
      if (why.empty()) continue;
      if (++count.failures <= options_.show) {
        const PosedPair shown = options_.raw ? pair : minimal(relation, pair);
        std::printf("%s %s (%s): %s\n", std::string(relation.name).c_str(), id.c_str(), count_name(kinds).c_str(),
                    check(relation, shown).c_str());
        if (const std::string line = record(shown, std::string(relation.name) + "-" + id); line.size() < 6000)
          std::printf("%s\n", line.c_str());
        std::fflush(stdout);
      }
    }
    ++judged_;
  }

  int finish() const {
    std::map<std::string, Count> sums;
    for (const auto& [key, count] : counts_) {
      sums[key[0]].pairs += count.pairs;
      sums[key[0]].failures += count.failures;
    }
    std::uint64_t failures = 0;
    std::printf("%-18s %10s %9s\n", "relation", "pairs", "failures");
    for (const auto& [relation, sum] : sums) {
      std::printf("%-18s %10llu %9llu", relation.c_str(), static_cast<unsigned long long>(sum.pairs),
                  static_cast<unsigned long long>(sum.failures));
      for (const auto& [key, count] : counts_)
        if (key[0] == relation && count.failures > 0)
          std::printf("  %s %llu/%llu", key[1].c_str(), static_cast<unsigned long long>(count.failures),
                      static_cast<unsigned long long>(count.pairs));
      std::printf("\n");
      failures += sum.failures;
    }
    std::printf("%llu pairs, %llu failures; inexact: %llu distances, %llu deepest contacts\n",
                static_cast<unsigned long long>(judged_), static_cast<unsigned long long>(failures),
                static_cast<unsigned long long>(inexact_), static_cast<unsigned long long>(inexact_contacts_));
    return failures > 0 ? 1 : 0;
  }

 private:
  static std::string count_name(const std::array<std::string_view, 2>& kinds) {
    return std::string(kinds[0]).append("-").append(kinds[1]);
  }

  const Options& options_;
  std::map<std::array<std::string, 2>, Count> counts_;
  std::uint64_t judged_ = 0, inexact_ = 0, inexact_contacts_ = 0;
};

int run(const Options& options) {
  Tally tally(options);
  if (!options.records.empty()) {
    std::ifstream file(options.records);
    if (!file) throw std::invalid_argument("cannot read " + options.records);
    ShapeReader shapes({std::filesystem::path(options.records).parent_path()});
    for (std::string line; std::getline(file, line);) {
      const PairRecord r = read_pair_record(Json::parse(line), shapes);
      if (r.a.shape.kind() == ShapeKind::halfspace && r.b.shape.kind() == ShapeKind::halfspace) continue;
      const double margin = r.margin > 0 ? r.margin : default_margin;
      tally.judge({{data_of(r.a.shape), r.a.pose}, {data_of(r.b.shape), r.b.pose}, margin, options.seed}, r.id.dump());
    }
    return tally.finish();
  }
  const DrawOptions draw{kind_of(options.a), kind_of(options.b), read_meshes(options.meshes, options.largest_mesh),
                         options.needles};
  for (std::uint64_t k = 0; k < options.pairs; ++k) {
    const std::uint64_t seed = options.seed + k;
    tally.judge(draw_pair(seed, draw), std::to_string(seed));
  }
  return tally.finish();
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::string list = "Relations:";
  for (const Relation& r : relations::relations()) list += "\n  " + std::string(r.name) + ": " + std::string(r.says);
  CLI::App app{"Holds answers of the narrow phase against each other.\n" + list};
  app.add_option("--seed", options.seed, "of the first pair; the next has the next number");
  app.add_option("--pairs", options.pairs, "how many");
  app.add_option("--relation", options.only, "only these")->delimiter(',');
  app.add_option("--a", options.a, "kind of A, else any");
  app.add_option("--b", options.b, "kind of B, else any");
  app.add_option("--meshes", options.meshes, "folder of .obj and .stl files to draw meshes from, too");
  app.add_option("--largest-mesh", options.largest_mesh, "of those, triangles");
  app.add_option("--records", options.records, "judges the pair records of this file instead");
  app.add_option("--show", options.show, "failures printed for a relation and two kinds");
  app.add_flag("--needles", options.needles,
               "only slivers and long thin hulls with something 1e3 to 1e8 times smaller");
  app.add_flag("--raw", options.raw, "prints pairs as they were drawn, not minimal ones");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "relations: %s\n", error.what());
    return 2;
  }
}
