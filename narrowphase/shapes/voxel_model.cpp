// Voxels: checks, Morton order, the hierarchy, mass.
#include "shapes/voxel_model.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>

#include "shapes/voxel_reach.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr std::int32_t grid_half = 1 << 20;
constexpr int most_level = 20;

/// A cell as one number: the interleaved bits of its corner's coordinates (Morton, A computer oriented geodetic data
/// base, 1966), x lowest. The cells within a cell of level l are the 8^l numbers from its own on.
using MortonKey = std::uint64_t;

MortonKey spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffffu;
  bits = (bits | bits << 16) & 0x001f0000ff0000ffu;
  bits = (bits | bits << 8) & 0x100f00f00f00f00fu;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3u;
  return (bits | bits << 2) & 0x1249249249249249u;
}

std::uint64_t gather(MortonKey key) {
  key &= 0x1249249249249249u;
  key = (key | key >> 2) & 0x10c30c30c30c30c3u;
  key = (key | key >> 4) & 0x100f00f00f00f00fu;
  key = (key | key >> 8) & 0x001f0000ff0000ffu;
  key = (key | key >> 16) & 0x001f00000000ffffu;
  return (key | key >> 32) & 0x1fffffu;
}

template <class Number>
MortonKey morton_key(const std::array<Number, 3>& corner) {
  const auto axis = [&](std::size_t k) { return spread(static_cast<std::uint64_t>(corner[k] + grid_half)); };
  return axis(0) | axis(1) << 1 | axis(2) << 2;
}

VoxelCell cell_at(MortonKey key, std::uint8_t level) {
  const auto axis = [&](int k) { return static_cast<std::int32_t>(gather(key >> k)) - grid_half; };
  return {{axis(0), axis(1), axis(2)}, level};
}

struct KeyedCell {
  MortonKey key;
  std::uint8_t level;

  MortonKey end() const { return key + (MortonKey{1} << 3 * level); }
  /// The order of cells: by corner; of two with the same corner the larger one, which contains the other, first.
  bool operator<(const KeyedCell& other) const { return key != other.key ? key < other.key : level > other.level; }
};

[[noreturn]] void refuse_voxels(const std::string& what, const std::string& found, const std::string& allowed) {
  throw std::invalid_argument("voxels: " + what + " is " + found + "; it must be " + allowed);
}

void require_grid(const Voxels& voxels) {
  const double size = voxels.cell_size;
  if (!(size >= tolerance::shortest_length && size <= tolerance::longest_length))
    refuse_voxels("cell_size", written(size),
                  "> 0, from " + written(tolerance::shortest_length) + " to " + written(tolerance::longest_length));
  for (int k = 0; k < 3; ++k)
    if (!(std::abs(voxels.origin[k]) * tolerance::cell_of_origin <= size))
      refuse_voxels("origin[" + std::to_string(k) + "]", written(voxels.origin[k]),
                    "a number up to " + written(size / tolerance::cell_of_origin) + ", so that cells are not rounded");
  if (voxels.cells.empty()) throw std::invalid_argument("voxels: cells is empty; at least one is needed");
  if (voxels.cells.size() > VoxelModel::most_cells)
    refuse_voxels("the number of cells", std::to_string(voxels.cells.size()),
                  "at most " + std::to_string(VoxelModel::most_cells));
}

void require_cell(const VoxelCell& cell, std::size_t number) {
  const std::string name = "cells[" + std::to_string(number) + "]";
  if (cell.level > most_level)
    refuse_voxels(name + ": level", std::to_string(cell.level), "at most " + std::to_string(most_level));
  const std::int32_t edge = 1 << cell.level;
  for (const std::int32_t at : cell.corner) {
    if (at < -grid_half || at > grid_half - edge)
      refuse_voxels(name, std::to_string(at),
                    "from " + std::to_string(-grid_half) + " to " + std::to_string(grid_half - edge));
    if (at % edge != 0) refuse_voxels(name, std::to_string(at), "a multiple of " + std::to_string(edge));
  }
}

std::vector<KeyedCell> sorted_keys(const std::vector<VoxelCell>& cells) {
  std::vector<KeyedCell> keys;
  keys.reserve(cells.size());
  for (const VoxelCell& cell : cells) {
    const auto number = static_cast<std::size_t>(&cell - cells.data());
    const std::int32_t edge = cell.level <= most_level ? 1 << cell.level : 0;
    bool allowed = edge > 0;
    for (const std::int32_t at : cell.corner)
      allowed = allowed && at >= -grid_half && at <= grid_half - edge && (at & (edge - 1)) == 0;
    if (!allowed) require_cell(cell, number);
    keys.push_back({morton_key(cell.corner), cell.level});
  }
  // An octree's leaves come in this order.
  if (!std::is_sorted(keys.begin(), keys.end())) std::sort(keys.begin(), keys.end());
  return keys;
}

/// Removes cells inside others, and merges eight that fill a larger one.
std::vector<KeyedCell> whole_octants(const std::vector<KeyedCell>& sorted) {
  std::vector<KeyedCell> whole;
  whole.reserve(sorted.size());
  const auto fill_parent = [&] {
    if (whole.size() < 8 || whole.back().level == most_level) return false;
    const std::span<const KeyedCell> eight = std::span<const KeyedCell>(whole).last(8);
    const MortonKey eighth = MortonKey{1} << 3 * eight[0].level;
    for (std::size_t k = 0; k < 8; ++k)
      if (eight[k].level != eight[0].level || eight[k].key != eight[0].key + k * eighth) return false;
    return eight[0].key % (8 * eighth) == 0;
  };
  for (const KeyedCell& cell : sorted) {
    if (!whole.empty() && cell.key < whole.back().end()) continue;
    whole.push_back(cell);
    while (fill_parent()) {
      whole.resize(whole.size() - 7);
      ++whole.back().level;
    }
  }
  return whole;
}

/// Boxes of nodes as shapes, enlarged by the rounding of positions.
void require_reach(const VoxelModel& model) {
  constexpr double widest = tolerance::longest_length / 2;
  const auto [middle, half] = model.box(model.root());
  if (const double farthest = (middle.cwiseAbs() + half).maxCoeff(); !(farthest <= tolerance::longest_length))
    refuse_voxels("the farthest coordinate", written(farthest), "at most " + written(tolerance::longest_length));
  if (const double width = 2 * half.maxCoeff(); !(width <= widest))
    refuse_voxels("the width of all cells", written(width), "at most " + written(widest));
}

/// Adds the nodes above `count` references from `first` on, whose boxes are known.
void add_level(VoxelModel& model, VoxelRef first, std::size_t count) {
  for (std::size_t i = 0; i < count; i += VoxelModel::fan) {
    const std::size_t children = std::min(VoxelModel::fan, count - i);
    VoxelModel::Node node;
    node.first = first + static_cast<VoxelRef>(i);
    node.count = static_cast<std::uint32_t>(children);
    std::tie(node.lo, node.hi) = model.span_of(node.first);
    for (std::size_t k = 1; k < children; ++k) {
      const auto [lo, hi] = model.span_of(node.first + static_cast<VoxelRef>(k));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.lo[axis] = std::min(node.lo[axis], lo[axis]);
        node.hi[axis] = std::max(node.hi[axis], hi[axis]);
      }
    }
    model.nodes.push_back(node);
  }
}

}  // namespace

VoxelModel build_voxels(const Voxels& voxels) {
  require_grid(voxels);
  VoxelModel model{.origin = voxels.origin, .cell_size = voxels.cell_size, .cells = {}, .nodes = {}, .boxes = {}};
  const std::vector<KeyedCell> whole = whole_octants(sorted_keys(voxels.cells));
  model.cells.reserve(whole.size());
  int largest = 0;
  for (const KeyedCell& cell : whole) {
    model.cells.push_back(cell_at(cell.key, cell.level));
    largest = std::max(largest, static_cast<int>(cell.level));
  }
  model.nodes.reserve(model.cells.size() / 7 + most_level);
  VoxelRef first = 0;
  std::size_t count = model.cells.size();
  do {
    add_level(model, first, count);
    first += static_cast<VoxelRef>(count);
    count = (count + VoxelModel::fan - 1) / VoxelModel::fan;
  } while (count > 1);
  model.nodes.shrink_to_fit();
  require_reach(model);
  for (int level = 0; level <= largest; ++level)
    model.boxes.push_back(Box{Vec3::Constant(std::ldexp(model.cell_size, level))});
  return model;
}

std::pair<std::array<std::int32_t, 3>, std::array<std::int32_t, 3>> VoxelModel::span_of(VoxelRef ref) const {
  if (!is_cell(ref)) return {node(ref).lo, node(ref).hi};
  const VoxelCell& cell = cells[ref];
  const std::int32_t edge = 1 << cell.level;
  return {cell.corner, {cell.corner[0] + edge, cell.corner[1] + edge, cell.corner[2] + edge}};
}

std::pair<Vec3, Vec3> VoxelModel::box(VoxelRef ref) const {
  const auto [lo, hi] = span_of(ref);
  const Vec3 low(lo[0], lo[1], lo[2]), high(hi[0], hi[1], hi[2]);
  return {origin + cell_size / 2 * (low + high), cell_size / 2 * (high - low)};
}

bool VoxelModel::has(const std::array<std::int64_t, 3>& place) const {
  for (const std::int64_t at : place)
    if (at < -grid_half || at >= grid_half) return false;
  const MortonKey key = morton_key(place);
  const auto after = std::upper_bound(cells.begin(), cells.end(), key, [](MortonKey sought, const VoxelCell& cell) {
    return sought < morton_key(cell.corner);
  });
  if (after == cells.begin()) return false;
  const VoxelCell& cell = *std::prev(after);
  return key < KeyedCell{morton_key(cell.corner), cell.level}.end();
}

double farthest_along(const VoxelModel& voxels, const Vec3& direction, const WorkLimit* limit) {
  const Vec3 steep = direction.cwiseAbs();
  WorkMeter meter(limit);
  return greatest_of_cells(
      voxels,
      [&](VoxelRef ref) {
        const auto [mid, half] = voxels.box(ref);
        return direction.dot(mid) + steep.dot(half);
      },
      meter);
}

MassProperties voxel_mass(const VoxelModel& voxels) {
  // In units of cells, about the middle of all: sums of integers and halves, which are exact.
  const auto [middle, half] = voxels.box(voxels.root());
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // of x x^T
  for (VoxelRef i = 0; i < voxels.cells.size(); ++i) {
    const auto [mid, half_edge] = voxels.box(i);
    const Vec3 at = (mid - middle) / voxels.cell_size;
    const double edge = std::ldexp(1.0, voxels.cells[i].level), cubes = edge * edge * edge;
    volume += cubes;
    first += cubes * at;
    second += cubes * (at * at.transpose() + Mat3(Vec3::Constant(edge * edge / 12).asDiagonal()));
  }
  const Vec3 centre = first / volume;
  const Mat3 spread_about = second - volume * centre * centre.transpose();
  const Mat3 inertia = spread_about.trace() * Mat3::Identity() - spread_about;
  const double s = voxels.cell_size;
  return {volume * s * s * s, middle + s * centre, inertia * (s * s * s) * (s * s)};
}

}  // namespace tandem
