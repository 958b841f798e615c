// Octrees from octomap's files.
#include "tandem/formats/octomap_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "formats/binary_numbers.h"
#include "formats/input_error.h"
#include "formats/text_file.h"

namespace tandem {
namespace {

constexpr int octree_depth = 16;                          // octomap's
constexpr std::size_t most_cells = std::size_t{1} << 26;  // of Voxels

/// The nodes behind a header: of .bt two bytes a node, of .ot a float and a byte (octomap 1.9, OcTreeBaseImpl).
class OctreeReader {
 public:
  OctreeReader(const std::string& file, std::string_view data) : file_(file), data_(data) {}

  Voxels read() {
    const std::string_view first = line();
    const bool is_binary = first == "# Octomap OcTree binary file";
    if (!is_binary && first != "# Octomap OcTree file")
      fail(0, quotation(first), "\"# Octomap OcTree binary file\" or \"# Octomap OcTree file\"");
    const bool has_nodes = read_header();
    constexpr std::int32_t least = -(1 << (octree_depth - 1));
    const VoxelCell root{{least, least, least}, octree_depth};
    if (has_nodes) is_binary ? read_binary(root) : read_full(root);
    if (at_ != data_.size()) fail(at_, std::to_string(data_.size() - at_) + " bytes behind the tree", "none");
    return std::move(voxels_);
  }

 private:
  [[noreturn]] void fail(std::size_t at, std::string_view found, std::string_view allowed) const {
    throw InputError(file_ + ": byte " + std::to_string(at), found, allowed);
  }

  /// Without blanks at its end.
  std::string_view line() {
    const std::size_t end = std::min(data_.find('\n', at_), data_.size());
    const std::string_view text = data_.substr(at_, end - at_);
    at_ = std::min(end + 1, data_.size());
    return text.substr(0, text.find_last_not_of(" \t\r") + 1);
  }

  /// Up to the line "data"; false: the tree has no nodes.
  bool read_header() {
    bool has_nodes = true;
    while (at_ < data_.size()) {
      const std::size_t begin = at_;
      const std::string_view text = line(), key = text.substr(0, text.find(' '));
      const std::string_view value = key.size() < text.size() ? text.substr(key.size() + 1) : std::string_view();
      if (key.starts_with('#') || key.empty()) continue;
      if (key == "data") {
        if (!(voxels_.cell_size > 0)) fail(begin, "no res", "a line \"res METRES\" before the data");
        return has_nodes;
      }
      if (key == "id" && value != "OcTree") fail(begin, quotation(value), "OcTree");
      if (key == "size") has_nodes = value != "0";
      if (key == "res") {
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), voxels_.cell_size);
        if (error != std::errc() || end != value.data() + value.size() || !(voxels_.cell_size > 0) ||
            !std::isfinite(voxels_.cell_size))
          fail(begin, quotation(text), "res and a number > 0");
      }
    }
    fail(at_, "end of file", "a line \"data\"");
  }

  const char* take(std::size_t bytes) {
    if (data_.size() - at_ < bytes) fail(data_.size(), "end of file", "the rest of the tree");
    const char* const from = data_.data() + at_;
    at_ += bytes;
    return from;
  }

  VoxelCell child(const VoxelCell& cell, unsigned i) const {
    if (cell.level == 0) fail(at_, "a node below level 16", "up to 16 levels");
    VoxelCell octant{cell.corner, static_cast<std::uint8_t>(cell.level - 1)};
    for (std::size_t k = 0; k < 3; ++k)
      if ((i >> k & 1u) != 0) octant.corner[k] += 1 << octant.level;
    return octant;
  }

  void add(const VoxelCell& cell) {
    if (voxels_.cells.size() == most_cells) fail(at_, "more occupied leaves", "at most " + std::to_string(most_cells));
    voxels_.cells.push_back(cell);
  }

  /// Two bits a child: none, a free leaf, an occupied leaf, a node.
  void read_binary(const VoxelCell& cell) {
    const unsigned children = little_endian<std::uint16_t>(take(2));
    constexpr unsigned occupied = 2, inner = 3;
    for (unsigned i = 0; i < 8; ++i)
      if ((children >> 2 * i & 3u) == occupied) add(child(cell, i));
    for (unsigned i = 0; i < 8; ++i)
      if ((children >> 2 * i & 3u) == inner) read_binary(child(cell, i));
  }

  /// Log odds, and a bit for each child that there is.
  void read_full(const VoxelCell& cell) {
    const char* const bytes = take(5);
    const auto odds = little_endian<float>(bytes);
    const auto children = static_cast<unsigned char>(bytes[4]);
    if (children == 0 && odds >= 0) add(cell);
    for (unsigned i = 0; i < 8; ++i)
      if ((children >> i & 1u) != 0) read_full(child(cell, i));
  }

  const std::string& file_;
  std::string_view data_;
  std::size_t at_ = 0;
  Voxels voxels_;
};

}  // namespace

Voxels read_octomap_file(const std::filesystem::path& path) {
  constexpr std::string_view begin = "# Octomap OcTree";
  const std::string file = path.string();
  InputFile input(path);
  std::string data(begin.size(), '\0');
  data.resize(input.read(data.data(), data.size()));
  // Another file is refused unread: a device may be endless.
  if (data == begin) data += input.rest(limits::mesh_bytes);
  return OctreeReader(file, data).read();
}

}  // namespace tandem
