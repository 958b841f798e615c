// Reads the includes of the libraries' sources.
#include "source_tree.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <optional>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace fs = std::filesystem;

namespace {

constexpr std::size_t no_folder = ~std::size_t{0};

void read_plan(const fs::path& plan, SourceTree& tree) {
  std::ifstream file(plan);
  if (!file) throw std::runtime_error(plan.string() + ": cannot be read");
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string what, library, word;
    if (!(words >> what) || what[0] == '#') continue;
    words >> library;
    if (what == "library") {
      auto& uses = tree.uses[library];
      while (words >> word) uses.insert(word);
    } else if (what == "folder" && tree.uses.contains(library) && words >> word) {
      tree.folders.push_back({library, word, {}, {}, 0});
      while (words >> word) tree.folders.back().public_headers.insert(word);
    } else {
      throw std::runtime_error(plan.string() + ": neither a library nor a folder of one: " + line);
    }
  }
}

class Reader {
 public:
  Reader(const fs::path& root, SourceTree& tree) : root_(root), tree_(tree) {}

  void read_all() {
    for (const auto& [library, uses] : tree_.uses)
      for (const auto& entry : fs::recursive_directory_iterator(root_ / library))
        if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
          files_.push_back(entry.path().lexically_relative(root_));
    std::sort(files_.begin(), files_.end());
    for (const fs::path& file : files_) read(file);
    find_circles();
  }

 private:
  /// The folder of a file by its path from the root; none if the plan has none for it.
  std::size_t folder_of(const fs::path& file) {
    const std::string library = file.begin()->string();
    const fs::path folder = file.parent_path().lexically_relative(library);
    const bool is_public = file.string().find("/include/tandem/") != std::string::npos;
    const std::string name = file.filename().string(),
                      with_folder = file.parent_path().filename().string() + "/" + name;
    // An adapter's header with the name of another public header is named with its folder.
    for (const std::string& header : {with_folder, name})
      for (std::size_t i = 0; i < tree_.folders.size(); ++i) {
        const Folder& of_plan = tree_.folders[i];
        if (of_plan.library == library &&
            (is_public ? of_plan.public_headers.contains(header) : of_plan.path == folder))
          return i;
      }
    return no_folder;
  }

  /// The file that an include names, by its path from the root; empty if it belongs to none of the libraries.
  std::optional<fs::path> resolve(const fs::path& from, const std::string& name) const {
    const std::string library = from.begin()->string();
    std::vector<fs::path> candidates = {from.parent_path() / name, fs::path(library) / name, name};
    for (const Folder& folder : tree_.folders)
      if (folder.library == library) candidates.push_back(fs::path(library) / folder.path / "include" / name);
    for (const auto& [other, uses] : tree_.uses) {
      candidates.push_back(fs::path(other) / "include" / name);
      candidates.push_back(fs::path(other) / name);
    }
    for (const fs::path& c : candidates) {
      const fs::path path = c.lexically_normal();
      if (std::binary_search(files_.begin(), files_.end(), path)) return path;
    }
    return std::nullopt;
  }

  void read(const fs::path& file) {
    const std::size_t folder = folder_of(file);
    if (folder == no_folder) return fault(file.string() + " is in no folder of the plan");
    const std::string unit = (file.parent_path() / file.stem()).string();
    tree_.folders[folder].units.insert(file.stem().string());
    std::ifstream text(root_ / file);
    static const std::regex include("\\s*#\\s*include \"([^\"]+)\".*");
    for (std::string line; std::getline(text, line);) {
      ++tree_.folders[folder].lines;
      std::smatch match;
      if (!std::regex_match(line, match, include)) continue;
      const auto target = resolve(file, match[1]);
      if (!target) continue;
      const std::string target_unit = (target->parent_path() / target->stem()).string();
      if (target_unit != unit) units_[unit].insert(target_unit);
      check(file, folder, *target);
    }
  }

  void check(const fs::path& file, std::size_t folder, const fs::path& target) {
    const std::size_t to = folder_of(target);
    if (to == no_folder) return;
    const Folder &here = tree_.folders[folder], &there = tree_.folders[to];
    const std::string text = file.string() + " includes " + target.string();
    if (here.library != there.library) {
      if (!tree_.uses[here.library].contains(there.library))
        fault(text + ": " + here.library + " may not use " + there.library);
      return;
    }
    if (to > folder) fault(text + ": " + there.path + " stands above " + here.path);
    if (to != folder) ++tree_.includes[{folder, to}];
  }

  /// Finds headers, with their sources, that include each other in a cycle.
  void find_circles() {
    std::map<std::string, int> state;  // 1: being visited, 2: done
    std::vector<std::string> path;
    const std::function<void(const std::string&)> visit = [&](const std::string& unit) {
      state[unit] = 1;
      path.push_back(unit);
      for (const std::string& next : units_[unit]) {
        if (state[next] == 0) visit(next);
        if (state[next] != 1) continue;
        std::string circle;
        for (auto i = std::find(path.begin(), path.end(), next); i != path.end(); ++i) circle += *i + " -> ";
        fault("a circle: " + circle + next);
      }
      path.pop_back();
      state[unit] = 2;
    };
    const auto all = units_;
    for (const auto& [unit, targets] : all)
      if (state[unit] == 0) visit(unit);
  }

  void fault(const std::string& text) { tree_.faults.push_back(text); }

  const fs::path root_;
  SourceTree& tree_;
  std::vector<fs::path> files_;
  std::map<std::string, std::set<std::string>> units_;
};

}  // namespace

SourceTree read_tree(const fs::path& plan, const fs::path& root) {
  SourceTree tree;
  read_plan(plan, tree);
  Reader(root, tree).read_all();
  return tree;
}
