#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

/// A folder of a library, on its layer.
struct Folder {
  std::string library, path;  ///< `path`: from the library's own folder
  std::set<std::string> public_headers;
  std::set<std::string> units;  ///< files by their names without extension: a header and its source are one
  int lines = 0;
};

/// What the plan allows and the includes of the sources do.
struct SourceTree {
  std::map<std::string, std::set<std::string>> uses;            ///< libraries that each library may include
  std::vector<Folder> folders;                                  ///< of each library from the ground up
  std::map<std::pair<std::size_t, std::size_t>, int> includes;  ///< from folder to folder: how many files
  std::vector<std::string> faults;                              ///< a line each; empty where the plan is kept
};

/// Reads the plan and all .h and .cpp files of its libraries below `root`. Throws std::runtime_error where the plan is
/// no plan.
SourceTree read_tree(const std::filesystem::path& plan, const std::filesystem::path& root);

/// A picture of it: a panel a library, a box a folder, an arc for each two folders of which the upper includes the
/// lower.
std::string draw_tree(const SourceTree& tree);
