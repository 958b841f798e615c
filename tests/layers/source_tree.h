// The includes of the libraries' sources, and the plan of their layers.
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

/// The plan, and the includes of the sources.
struct SourceTree {
  std::map<std::string, std::set<std::string>> uses;            ///< libraries that each library may include
  std::vector<Folder> folders;                                  ///< of each library from the lowest layer up
  std::map<std::pair<std::size_t, std::size_t>, int> includes;  ///< from folder to folder: number of files
  std::vector<std::string> faults;                              ///< a line each; empty if the plan is obeyed
};

/// Reads the plan and all .h and .cpp files of its libraries below `root`. Throws std::runtime_error for an invalid
/// plan.
SourceTree read_tree(const std::filesystem::path& plan, const std::filesystem::path& root);

/// An SVG picture: a panel for each library, a box for each folder, an arc for each two folders of which the upper
/// includes the lower.
std::string draw_tree(const SourceTree& tree);
