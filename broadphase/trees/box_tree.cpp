// Builds the hierarchy of boxes along a space-filling curve, and joins it with itself.
#include "trees/box_tree.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "kernels/row_kernel.h"
#include "storage/memory.h"

namespace tandem {
namespace {

using Hits = std::array<std::uint32_t, 8 + BoxArray::padding>;

Cube cube_around(const std::array<Extent, 3>& extents) {
  Cube cube;
  double side = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    cube.lo[k] = extents[k].lo;
    side = std::max(side, extents[k].hi - extents[k].lo);
  }
  cube.inverse_side = side > 0 ? 1 / side : 0;
  return cube;
}

/// Sorts stably by the high half of the keys, of which `bits` low bits are used; by radix where that is faster.
void sort_keys(std::span<std::uint64_t> keys, std::vector<std::uint64_t>& spare, int bits) {
  constexpr int digit_bits = 8;
  if (keys.size() < 200) return std::sort(keys.begin(), keys.end());
  if (spare.size() < keys.size()) spare.resize(keys.size());
  std::uint64_t *from = keys.data(), *to = spare.data();
  for (int shift = 32; shift < 32 + bits; shift += digit_bits) {
    std::array<std::uint32_t, 1u << digit_bits> place{};
    for (std::size_t i = 0; i < keys.size(); ++i) ++place[(from[i] >> shift) & 0xff];
    std::uint32_t sum = 0;
    for (std::uint32_t& p : place) sum += std::exchange(p, sum);
    for (std::size_t i = 0; i < keys.size(); ++i) to[place[(from[i] >> shift) & 0xff]++] = from[i];
    std::swap(from, to);
  }
  if (from != keys.data()) std::copy(from, from + keys.size(), keys.data());
}

/// Orders keys, whose low halves are positions in `records`, along the curve; equal codes by position. A run of equal
/// codes spans at most 1/256 of the range that it came from and lacks at least one of its ends, so the refinement
/// terminates: after 36 rounds at most for floats.
template <class Record>
void sort_along_curve(const Record* records, std::span<std::uint64_t> keys, std::vector<std::uint64_t>& spare) {
  constexpr int bits = 8;            // an axis
  constexpr std::size_t enough = 8;  // boxes that share a leaf anyway
  std::vector<std::span<std::uint64_t>> todo{keys};
  while (!todo.empty()) {
    const std::span<std::uint64_t> run = todo.back();
    todo.pop_back();
    std::array<Extent, 3> extents;
    for (std::size_t k = 0; k < 3; ++k) {
      double lo = std::numeric_limits<double>::infinity(), hi = -lo;
      for (const std::uint64_t key : run) {
        const Aabb& box = records[static_cast<std::uint32_t>(key)].box;
        const double centre = 0.5 * (double{box.lo[k]} + double{box.hi[k]});
        lo = std::min(lo, centre);
        hi = std::max(hi, centre);
      }
      extents[k] = {lo, hi};
    }
    const Cube cube = cube_around(extents);
    if (cube.inverse_side == 0) continue;  // all centres coincide
    for (std::uint64_t& key : run) {
      const auto position = static_cast<std::uint32_t>(key);
      key = std::uint64_t{cube.morton(records[position].box, bits)} << 32 | position;
    }
    sort_keys(run, spare, 3 * bits);
    for (std::size_t first = 0; first < run.size();) {
      std::size_t last = first + 1;
      while (last < run.size() && run[last] >> 32 == run[first] >> 32) ++last;
      if (last - first > enough) todo.push_back(run.subspan(first, last - first));
      first = last;
    }
  }
}

/// A box's centre, finite even where a bound is infinite, and its position along the curve.
struct Centre {
  std::array<float, 3> at;
  std::uint32_t place;
};

Centre centre_of(const Aabb& box, std::size_t place) {
  constexpr double most = std::numeric_limits<float>::max();
  Centre centre{{}, static_cast<std::uint32_t>(place)};
  for (std::size_t k = 0; k < 3; ++k)
    centre.at[k] = static_cast<float>(0.5 * (std::max(double{box.lo[k]}, -most) + std::min(double{box.hi[k]}, most)));
  return centre;
}

std::size_t longest_axis(std::span<const Centre> centres) {
  std::array<float, 3> lo = centres[0].at, hi = lo;
  for (const Centre& centre : centres)
    for (std::size_t k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], centre.at[k]);
      hi[k] = std::max(hi[k], centre.at[k]);
    }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (hi[k] - lo[k] > hi[axis] - lo[axis]) axis = k;
  return axis;
}

/// Orders centres so that each `unit` of them, and each eighth of a unit down to single nodes, lie close together.
void halve(std::span<Centre> centres, std::size_t unit) {
  const std::size_t units = (centres.size() + unit - 1) / unit;
  if (units > 1) {
    const std::size_t axis = longest_axis(centres), left = units / 2 * unit;
    std::nth_element(centres.begin(), centres.begin() + static_cast<std::ptrdiff_t>(left), centres.end(),
                     [axis](const Centre& a, const Centre& b) {
                       return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.place < b.place;
                     });
    halve(centres.first(left), unit);
    halve(centres.subspan(left), unit);
  } else if (unit > BoxTree::width) {
    halve(centres, unit / BoxTree::width);
  } else {
    std::sort(centres.begin(), centres.end(), [](const Centre& a, const Centre& b) { return a.place < b.place; });
  }
}

}  // namespace

// Stages: choose cells, count, plan, scatter, sort cells, lower levels, upper levels.
void BoxTree::begin(const BoxArray& boxes, const std::vector<std::uint32_t>* subset, Order order) {
  boxes_ = &boxes;
  order_ = order;
  subset_ = subset;
  const std::size_t n = items();
  cell_bits_ = n <= 8192 ? 0 : 4;
  items_a_block_ = std::max<std::size_t>(8192, (n + 63) / 64);
  const std::size_t parts = (n + items_a_block_ - 1) / items_a_block_;
  offsets_.assign(parts << 3 * cell_bits_, 0);
  cell_.resize(n);
  height_ = 0;
  group_cells_.clear();
  place_.clear();
}

std::size_t BoxTree::blocks(std::size_t stage) const {
  switch (stage) {
    case 1:
    case 3:
      return offsets_.size() >> 3 * cell_bits_;
    case 4:
      return group_cells_.size();
    case 5:
      return height_ == 0 ? 0 : (levels_[0].size() + boxes_a_level_block - 1) / boxes_a_level_block;
    default:
      return 1;
  }
}

void BoxTree::run(std::size_t stage, std::size_t block) {
  switch (stage) {
    case 0:
      return choose_cells();
    case 1:
      return count_cells(block);
    case 2:
      return plan();
    case 3:
      return scatter(block);
    case 4:
      return sort_cells(block);
    case 5:
      if (order_ == Order::halves) halve_run(block * boxes_a_level_block, (block + 1) * boxes_a_level_block);
      for (std::size_t level = 1, size = boxes_a_level_block / width; level <= levels_a_block && level < height_;
           ++level, size /= width)
        raise(level, block * size, (block + 1) * size);
      return;
    default:
      for (std::size_t level = levels_a_block + 1; level < height_; ++level) raise(level, 0, levels_[level].size());
  }
}

void BoxTree::choose_cells() {
  if (cell_bits_ == 0) return;
  const std::vector<Aabb> sample = sample_boxes(*boxes_, subset_);
  cube_ = cube_around({bulk(sample, 0), bulk(sample, 1), bulk(sample, 2)});
}

void BoxTree::count_cells(std::size_t block) {
  std::uint32_t* count = offsets_.data() + (block << 3 * cell_bits_);
  for (std::size_t i = block * items_a_block_, end = std::min(items(), i + items_a_block_); i < end; ++i) {
    const Aabb box = (*boxes_)[item(i)];
    if (box.lo[0] > box.hi[0]) continue;
    cell_[i] = cell_bits_ == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(cube_.morton(box, cell_bits_));
    ++count[cell_[i]];
  }
}

void BoxTree::plan() {
  const std::size_t cells = std::size_t{1} << 3 * cell_bits_;
  cell_begin_.resize(cells + 1);
  std::uint32_t sum = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    cell_begin_[cell] = sum;
    for (std::size_t at = cell; at < offsets_.size(); at += cells) sum += std::exchange(offsets_[at], sum);
  }
  cell_begin_[cells] = sum;

  constexpr std::size_t boxes_a_sort = 2048;
  for (std::size_t first = 0; first < cells;) {
    std::size_t last = first + 1;
    while (last < cells && cell_begin_[last] - cell_begin_[first] < boxes_a_sort) ++last;
    if (cell_begin_[last] > cell_begin_[first]) group_cells_.push_back({first, last});
    first = last;
  }

  records_.resize(sum);
  index_.resize(sum);
  std::size_t size = sum;
  while (size > 0) {
    if (levels_.size() == height_) levels_.emplace_back();
    levels_[height_++].resize(size);
    if (size == 1) break;
    size = (size + width - 1) / width;
  }
}

void BoxTree::scatter(std::size_t block) {
  std::uint32_t* place = offsets_.data() + (block << 3 * cell_bits_);
  for (std::size_t i = block * items_a_block_, end = std::min(items(), i + items_a_block_); i < end; ++i) {
    const Aabb box = (*boxes_)[item(i)];
    if (box.lo[0] <= box.hi[0]) records_[place[cell_[i]]++] = {box, item(i)};
  }
}

void BoxTree::sort_cells(std::size_t block) {
  const Range cells = group_cells_[block];
  std::vector<std::uint64_t> keys, spare;
  for (std::size_t cell = cells.begin; cell < cells.end; ++cell) {
    const std::size_t first = cell_begin_[cell], size = cell_begin_[cell + 1] - first;
    const Record* records = records_.data() + first;
    keys.resize(size);
    for (std::size_t i = 0; i < size; ++i) keys[i] = i;
    if (size > 1) sort_along_curve(records, std::span(keys), spare);
    for (std::size_t i = 0; i < size; ++i) {
      const Record& record = records[static_cast<std::uint32_t>(keys[i])];
      levels_[0].set(first + i, record.box);
      index_[first + i] = record.index;
    }
  }
}

std::size_t BoxTree::children_end(std::size_t level, std::size_t node) const {
  return std::min((node + 1) * width, levels_[level - 1].size());
}

void BoxTree::halve_run(std::size_t first, std::size_t last) {
  last = std::min(last, levels_[0].size());
  if (last - first <= width) return;
  std::vector<Record> run;
  std::vector<Centre> centres;
  run.reserve(last - first);
  centres.reserve(last - first);
  for (std::size_t place = first; place < last; ++place) {
    run.push_back({levels_[0][place], index_[place]});
    centres.push_back(centre_of(run.back().box, place - first));
  }
  halve(centres, boxes_a_level_block / width);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    levels_[0].set(first + i, run[centres[i].place].box);
    index_[first + i] = run[centres[i].place].index;
  }
}

void BoxTree::raise(std::size_t level, std::size_t first, std::size_t last) {
  last = std::min(last, levels_[level].size());
  if (first < last) unite_rows(levels_[level - 1], first, last, levels_[level]);
}

void BoxTree::find_places() {
  if (!place_.empty()) return;
  place_.assign(index_.size(), nowhere);  // the array of an earlier build may be gone
  for (std::size_t place = 0; place < index_.size(); ++place) {
    if (index_[place] >= place_.size()) place_.resize(index_[place] + 1, nowhere);
    place_[index_[place]] = static_cast<std::uint32_t>(place);
  }
}

template <class Boxes>
bool BoxTree::refit_from(const Boxes& boxes, std::span<const std::uint32_t> changed) {
  find_places();
  for (const std::uint32_t index : changed)
    if (index >= place_.size() || place_[index] == nowhere) return false;
  if (changed.size() > index_.size() / all_at_once) {
    for (std::size_t place = 0; place < index_.size(); ++place) levels_[0].set(place, boxes[index_[place]]);
    for (std::size_t level = 1; level < height_; ++level) raise(level, 0, levels_[level].size());
    return true;
  }
  moved_.clear();
  for (const std::uint32_t index : changed) moved_.push_back(place_[index]);
  std::sort(moved_.begin(), moved_.end());
  for (const std::uint32_t place : moved_) levels_[0].set(place, boxes[index_[place]]);
  for (std::size_t level = 1; level < height_; ++level) {
    for (std::uint32_t& node : moved_) node /= width;
    moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());
    for (const std::uint32_t node : moved_) raise(level, node, node + 1);
  }
  return true;
}

bool BoxTree::refit(const BoxArray& boxes, std::span<const std::uint32_t> changed) {
  return refit_from(boxes, changed);
}
bool BoxTree::refit(std::span<const Aabb> boxes, std::span<const std::uint32_t> changed) {
  return refit_from(boxes, changed);
}

double BoxTree::surface() const {
  double sum = 0;
  if (height_ > 1)
    for (std::size_t node = 0; node < levels_[1].size(); ++node) {
      const Aabb box = levels_[1][node];
      if (box.lo[0] > box.hi[0]) continue;
      const double x = double{box.hi[0]} - box.lo[0], y = double{box.hi[1]} - box.lo[1],
                   z = double{box.hi[2]} - box.lo[2];
      sum += x * y + y * z + z * x;
    }
  return sum;
}

namespace {

/// The level whose nodes are the blocks of the self join: nodes of 512 boxes, or 64 in small worlds.
std::size_t block_level(std::size_t height, std::size_t boxes) {
  return std::min<std::size_t>(height - 1, boxes > 16384 ? 3 : 2);
}

}  // namespace

std::size_t BoxTree::self_blocks() const {
  return height_ == 0 ? 0 : levels_[block_level(height_, levels_[0].size())].size();
}

void BoxTree::self_pairs(std::size_t block, PairSink& sink) const { pairs_from(height_ - 1, 0, block, sink); }

// Finds the nodes, from `from` on and at the level of blocks, that overlap node `from`.
void BoxTree::pairs_from(std::size_t level, std::size_t node, std::size_t from, PairSink& sink) const {
  const std::size_t target = block_level(height_, levels_[0].size());
  if (level == target) return cross(level, from, node, sink);
  const std::size_t own = from >> 3 * (level - 1 - target);  // nodes before it are another block's
  const std::size_t first = std::max(node * width, own), end = children_end(level, node);
  if (first >= end) return;
  Hits hits;
  const std::size_t count = overlap_row(levels_[level - 1], first, end, levels_[target][from], hits.data());
  for (std::size_t k = 0; k < count; ++k) pairs_from(level - 1, hits[k], from, sink);
}

// Pairs of boxes below i with boxes below j, for nodes i <= j that overlap or are the same.
void BoxTree::cross(std::size_t level, std::size_t i, std::size_t j, PairSink& sink) const {
  if (level == 0) return;  // a tree of one box
  const BoxArray& below = levels_[level - 1];
  const std::size_t j_end = children_end(level, j);
  Hits left, right;
  const std::size_t lefts = overlap_row(below, i * width, children_end(level, i), levels_[level][j], left.data());
  for (std::size_t l = 0; l < lefts; ++l) {
    const std::size_t a = left[l];
    const std::size_t first = i == j ? (level == 1 ? a + 1 : a) : j * width;
    const std::size_t rights = overlap_row(below, first, j_end, below[a], right.data());
    for (std::size_t r = 0; r < rights; ++r) {
      if (level == 1)
        sink.put(index_[a], index_[right[r]]);
      else
        cross(level - 1, a, right[r], sink);
    }
  }
}

std::size_t BoxTree::memory() const {
  std::size_t bytes = bytes_of(offsets_) + bytes_of(cell_) + bytes_of(cell_begin_) + bytes_of(group_cells_) +
                      bytes_of(records_) + bytes_of(index_) + bytes_of(place_) + bytes_of(moved_) + bytes_of(levels_);
  for (const BoxArray& level : levels_) bytes += level.memory();
  return bytes;
}

void BoxTree::query(const Aabb& box, std::uint32_t index, PairSink& sink) const {
  if (height_ == 0 || !overlap(box, levels_[height_ - 1][0])) return;
  query_from(height_ - 1, 0, box, index, sink);
}

void BoxTree::query_from(std::size_t level, std::size_t node, const Aabb& box, std::uint32_t index,
                         PairSink& sink) const {
  if (level == 0) return sink.put(index, index_[node]);
  Hits hits;
  const std::size_t count = overlap_row(levels_[level - 1], node * width, children_end(level, node), box, hits.data());
  for (std::size_t k = 0; k < count; ++k) query_from(level - 1, hits[k], box, index, sink);
}

}  // namespace tandem
