// Uniform grid of columns: the layout of the columns, counting, scattering, and the tests of each column.
#include "methods/grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "kept_candidates/candidate_tiles.h"
#include "kernels/row_kernel.h"
#include "trees/spatial_sample.h"

namespace tandem {
namespace {

/// At most `wanted` of the sample, evenly.
std::vector<Aabb> thin_out(const std::vector<Aabb>& sample, std::size_t wanted) {
  std::vector<Aabb> some(std::min(sample.size(), wanted));
  for (std::size_t i = 0; i < some.size(); ++i) some[i] = sample[i * sample.size() / some.size()];
  return some;
}

/// The share of pairs of sampled boxes that overlap on an axis; never 0.
double share_that_overlaps(const std::vector<Aabb>& sample, std::size_t axis) {
  const std::size_t n = sample.size();
  std::size_t hits = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      hits += sample[i].lo[axis] <= sample[j].hi[axis] && sample[j].lo[axis] <= sample[i].hi[axis] ? 1 : 0;
  return n < 2 ? 1 : (static_cast<double>(hits) + 1) / (static_cast<double>(n * (n - 1) / 2) + 1);
}

}  // namespace

Grid::Touched Grid::touched(const Aabb& box) const {
  return {u_.at(box.lo[u_.axis]), u_.at(box.hi[u_.axis]), v_.at(box.lo[v_.axis]), v_.at(box.hi[v_.axis])};
}

// Stages: choose the columns, emit. Joint stages within the second: count, plan, scatter, the tree's.
std::size_t Grid::begin(const BoxArray& boxes) {
  boxes_ = &boxes;
  size_ = boxes.size();
  boxes_a_block_ = std::max<std::size_t>(4096, ((size_ + 63) / 64 + 63) / 64 * 64);
  parts_ = std::max<std::size_t>(1, (size_ + boxes_a_block_ - 1) / boxes_a_block_);
  large_of_part_.resize(parts_);
  role_.resize(size_);
  groups_.clear();
  large_.clear();
  crowded_ = searched_ = false;
  longest_column_ = 0;
  early_.leave_out();
  joint_.start(joint_stages, parts_);
  return 2;
}

// The number of blocks of the last stage must be known before it is prepared.
std::size_t Grid::blocks(std::size_t stage) const { return stage == 0 ? 1 : 2 + size_ / boxes_a_tile; }

void Grid::run(std::size_t, std::size_t) { choose_columns(); }

bool Grid::prepare() {
  return joint_.join([this](std::size_t stage) { return joint_blocks(stage); },
                     [this](std::size_t stage, std::size_t block) { run_joint(stage, block); });
}

std::size_t Grid::joint_blocks(std::size_t stage) const {
  if (stage == 1) return 1;
  if (stage == 2) return crowded_ ? 0 : parts_;
  return use_tree() ? tree_.blocks(stage - first_tree_stage) : 0;
}

void Grid::run_joint(std::size_t stage, std::size_t block) {
  switch (stage) {
    case 0:
      return count(block);
    case 1:
      return plan();
    case 2:
      return scatter(block);
    default:
      return tree_.run(stage - first_tree_stage, block);
  }
}

void Grid::choose_columns() {
  const std::vector<Aabb> sample = sample_boxes(*boxes_);
  if (!searched_) early_.choose(*boxes_, sample);  // else all is kept for later
  const std::array<Extent, 3> extents{bulk(sample, 0), bulk(sample, 1), bulk(sample, 2)};
  const auto length = [&](std::size_t axis) { return extents[axis].hi - extents[axis].lo; };

  // Columns along the middle extent: then worlds that are a plane or a line are still cut along what they have.
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::sort(axes.begin(), axes.end(),
            [&](std::size_t a, std::size_t b) { return length(a) != length(b) ? length(a) < length(b) : a < b; });
  along_ = axes[1];
  u_ = {axes[2], static_cast<float>(0.5 * extents[axes[2]].lo), 0, 1};
  v_ = {axes[0], static_cast<float>(0.5 * extents[axes[0]].lo), 0, 1};
  const std::vector<Aabb> judged = thin_out(sample, 96);
  overlap_along_ = share_that_overlaps(judged, along_);

  // Nanoseconds: of an entry and a vector fitted to unit boxes and piles of 100,000 (the minimum is flat), the others
  // by order of magnitude. Each column is a page that is written to: beyond some thousand the pages' addresses are no
  // longer cached.
  constexpr double entry_cost = 16, far_entry_cost = 6, near_columns = 1200, vector_cost = 7, large_row_cost = 0.3,
                   large_tree_cost = 60, tree_cost = 400, count_cost = 0.6;
  const auto n = static_cast<double>(size_);
  const double max_columns = std::clamp(n / 8, 1.0, 16384.0);
  const double length_u = length(u_.axis), length_v = length(v_.axis);
  double best = std::numeric_limits<double>::infinity();
  for (double cuts = 1; cuts <= max_columns && length_u > 0; cuts *= 1.3) {
    const double count_u = std::floor(cuts), width = length_u / count_u;
    const double count_v = std::max(1.0, std::floor(length_v / width)), width_v = length_v / count_v;
    if (count_u * count_v > max_columns) break;
    double entries = 0, large = 0;
    for (const Aabb& box : judged) {
      const auto span = [&](std::size_t axis, double slice, double count) {
        return count == 1 ? 1.0 : std::min(count, 1 + (double{box.hi[axis]} - double{box.lo[axis]}) / slice);
      };
      const double touched = span(u_.axis, width, count_u) * span(v_.axis, width_v, count_v);
      if (touched > max_columns_a_box)
        ++large;
      else
        entries += touched;
    }
    entries /= static_cast<double>(judged.size());
    const double large_share = large / static_cast<double>(judged.size());
    large *= n / static_cast<double>(judged.size());
    const double column_size = n * entries / (count_u * count_v);
    const double candidates = 0.5 + column_size * overlap_along_ / 2;
    const double placing = entry_cost + (count_u * count_v > near_columns ? far_entry_cost : 0);
    const double cost = entries * (placing + vector_cost * (1 + candidates / 8)) +
                        std::min(large * large_row_cost, large_tree_cost + large_share * tree_cost) +
                        count_cost * count_u * count_v * static_cast<double>(parts_) / n;
    if (cost >= best) continue;
    best = cost;
    const auto inverse = [](double w) { return static_cast<float>(std::min(2 / w, 1e38)); };
    u_.count = static_cast<std::uint32_t>(count_u);
    v_.count = static_cast<std::uint32_t>(count_v);
    u_.inverse_half_width = count_u > 1 ? inverse(width) : 0;
    v_.inverse_half_width = count_v > 1 ? inverse(width_v) : 0;
  }
  offsets_.assign(parts_ * columns(), 0);
}

void Grid::find_touched(std::size_t first, std::size_t count, TouchedRows& rows) const {
  const int u = static_cast<int>(u_.axis), v = static_cast<int>(v_.axis);
  slices_of(u_, boxes_->lo(u) + first, count, rows.slices[0].data());
  slices_of(u_, boxes_->hi(u) + first, count, rows.slices[1].data());
  slices_of(v_, boxes_->lo(v) + first, count, rows.slices[2].data());
  slices_of(v_, boxes_->hi(v) + first, count, rows.slices[3].data());
}

void Grid::count(std::size_t block) {
  std::uint32_t* counts = offsets_.data() + block * columns();
  std::vector<std::uint32_t>& large = large_of_part_[block];
  large.clear();
  const std::size_t begin = block * boxes_a_block_, end = std::min(size_, begin + boxes_a_block_);
  const float *lo = boxes_->lo(0), *hi = boxes_->hi(0);
  const std::size_t row = u_.count;
  TouchedRows rows;
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t k = (i - begin) % TouchedRows::most;
    if (k == 0) find_touched(i, std::min(TouchedRows::most, end - i), rows);
    const Touched t = rows[k];
    const std::uint32_t du = t.u1 - t.u0, dv = t.v1 - t.v0;
    role_[i] = Role::entered;
    if (!(lo[i] <= hi[i])) {
      role_[i] = Role::empty;
    } else if ((du | dv) <= 1) {
      // Without branches: how many columns a box touches is not to be foreseen.
      std::uint32_t* at = counts + t.v0 * row + t.u0;
      at[0] += 1;
      at[du] += du;
      at[dv * row] += dv;
      at[dv * row + du] += du & dv;
    } else if (t.count() > max_columns_a_box) {
      role_[i] = Role::large;
      large.push_back(static_cast<std::uint32_t>(i));
    } else {
      for (std::uint32_t v = t.v0; v <= t.v1; ++v)
        for (std::uint32_t u = t.u0; u <= t.u1; ++u) ++counts[v * row + u];
    }
  }
}

void Grid::plan() {
  column_begin_.resize(columns() + 1);
  std::uint32_t sum = 0;
  double tests = 0;
  for (std::size_t column = 0; column < columns(); ++column) {
    column_begin_[column] = sum;
    for (std::size_t part = 0; part < parts_; ++part) sum += std::exchange(offsets_[part * columns() + column], sum);
    const std::size_t entries = sum - column_begin_[column];
    longest_column_ = std::max(longest_column_, entries);
    tests += static_cast<double>(entries) * static_cast<double>(entries) / 2 * overlap_along_;
  }
  column_begin_[columns()] = sum;
  for (const auto& part : large_of_part_) large_.insert(large_.end(), part.begin(), part.end());

  // By estimate the tree takes the time of some 500 tests a box.
  constexpr double max_tests_a_box = 500;
  // A column is one block's work: longer ones would leave the other threads idle. (A 32nd of the boxes sent 200,000
  // grains in a wide box to the tree, which took twice as long.)
  const std::size_t max_entries_a_column = std::clamp<std::size_t>(size_ / 16, 8192, 65536);
  crowded_ = tests > max_tests_a_box * static_cast<double>(size_) || longest_column_ > max_entries_a_column;
  if (crowded_) large_.clear();
  if (use_tree()) tree_.begin(*boxes_, crowded_ ? nullptr : &large_);
  if (crowded_) return;

  if (sum > records_.capacity()) {
    records_.clear();                  // what was there need not be copied
    records_.reserve(sum + sum / 16);  // the boxes may grow
  }
  records_.resize(sum);
  if (searched_) {
    thin_.assign(columns(), {});
    std::size_t cells = 0;
    for (std::size_t column = 0; column < columns(); ++column) {
      thin_[column].first_cell = cells;
      cells += std::bit_ceil(column_begin_[column + 1] - column_begin_[column]);
    }
    cell_end_.resize(cells);
  }
  constexpr std::size_t entries_a_block = 1024;
  for (std::size_t first = 0; first < columns();) {
    std::size_t last = first + 1;
    while (last < columns() && column_begin_[last + 1] - column_begin_[first] <= entries_a_block) ++last;
    if (column_begin_[last] > column_begin_[first]) groups_.push_back({first, last});
    first = last;
  }
}

void Grid::scatter(std::size_t block) {
  std::uint32_t* place = offsets_.data() + block * columns();
  const std::uint32_t row = u_.count;
  std::array<ColumnEntry, (max_boxes_a_scatter + 1) * max_columns_a_box> entries;
  const std::size_t begin = block * boxes_a_block_, end = std::min(size_, begin + boxes_a_block_);
  TouchedRows rows;
  static_assert(max_boxes_a_scatter <= TouchedRows::most);
  for (std::size_t from = begin; from < end; from += max_boxes_a_scatter) {
    std::size_t count = 0;
    const std::size_t boxes = std::min(max_boxes_a_scatter, end - from);
    find_touched(from, boxes, rows);
    for (std::size_t k = 0; k < boxes; ++k) {
      if (role_[from + k] != Role::entered) continue;
      const Touched t = rows[k];
      const std::uint32_t du = t.u1 - t.u0, dv = t.v1 - t.v0, column = t.v0 * row + t.u0;
      const auto box = static_cast<std::uint16_t>(k);
      if ((du | dv) <= 1) {
        // As in `count`: all four are written, those that it does not touch are written over.
        entries[count] = {column, box, 3};
        entries[count += 1] = {column + 1, box, 2};
        entries[count += du] = {column + row, box, 1};
        entries[count += dv] = {column + row + 1, box, 0};
        count += du & dv;
        continue;
      }
      for (std::uint32_t v = t.v0; v <= t.v1; ++v)
        for (std::uint32_t u = t.u0; u <= t.u1; ++u)
          entries[count++] = {v * row + u, box,
                              static_cast<std::uint16_t>((u == t.u0 ? 1u : 0u) | (v == t.v0 ? 2u : 0u))};
    }
    scatter_records(*boxes_, from, entries.data(), count, place, records_.data());
  }
}

std::size_t Grid::large_blocks() const {
  return crowded_ || large_.empty() ? 0 : (size_ + boxes_a_large_block - 1) / boxes_a_large_block;
}

Grid::Range Grid::tile(std::size_t block) const {
  const std::size_t tiles = blocks(1) - 1;
  const std::size_t parts = groups_.size() + large_blocks() + (use_tree() ? tree_.self_blocks() : 0);
  return {(block - 1) * parts / tiles, block * parts / tiles};
}

void Grid::emit(std::size_t block, PairSink& sink) {
  if (block == 0) return early_.emit(sink);
  if (!prepare()) return;
  const Range parts = tile(block);
  for (std::size_t part = parts.begin; part < parts.end; ++part) {
    if (part < groups_.size()) {
      emit_group(part, sink);
    } else if (early_.taken()) {
      LaterPairs later(early_, *boxes_, sink);
      emit_beside(part - groups_.size(), later);
      later.flush();
    } else {
      emit_beside(part - groups_.size(), sink);
    }
  }
}

void Grid::emit_group(std::size_t group, PairSink& sink) {
  const detail::ScratchPool<ColumnScratch>::Lease scratch(scratch_);
  const bool early = early_.taken();
  const std::vector<std::uint32_t>& index = (*scratch).column.index;
  for (std::size_t column = groups_[group].begin; column < groups_[group].end; ++column) {
    if (!sort(column, *scratch)) continue;
    if (early && may_hold_early(column)) {
      const std::vector<float>& lo = (*scratch).column.bounds[early_.axis()];
      each_pair(*scratch, [&](std::span<const RowPair> pairs) {
        for (const RowPair pair : pairs)
          if (!early_.holds(lo[pair.row], lo[pair.other])) sink.put(index[pair.row], index[pair.other]);
      });
    } else {
      each_pair(*scratch, [&](std::span<const RowPair> pairs) {
        for (const RowPair pair : pairs) sink.put(index[pair.row], index[pair.other]);
      });
    }
  }
}

// A pair belongs to the column where its intersection begins.
bool Grid::may_hold_early(std::size_t column) const {
  const auto may = [this](const Slices& slices, std::size_t place) {
    return slices.axis != early_.axis() || (slices.at(early_.begin()) <= place && place <= slices.at(early_.end()));
  };
  return may(u_, column % u_.count) && may(v_, column / u_.count);
}

void Grid::emit_beside(std::size_t part, PairSink& sink) const {
  const std::size_t self_blocks = use_tree() ? tree_.self_blocks() : 0;
  if (part < self_blocks) return tree_.self_pairs(part, sink);
  emit_large(part - self_blocks, sink);
}

bool Grid::emit_tiles(std::size_t block, TileMaker& maker) {
  if (block == 0 || !prepare()) return true;
  const detail::ScratchPool<ColumnScratch>::Lease scratch(scratch_);
  const std::vector<std::uint32_t>& index = (*scratch).column.index;
  const Range parts = tile(block);
  for (std::size_t part = parts.begin; part < parts.end; ++part) {
    if (part >= groups_.size()) {
      emit_beside(part - groups_.size(), maker);
      continue;
    }
    for (std::size_t column = groups_[part].begin; column < groups_[part].end; ++column) {
      maker.start_rows(column_begin_[column + 1] - column_begin_[column]);
      if (!sort(column, *scratch)) continue;
      each_pair(*scratch, [&](std::span<const RowPair> pairs) { maker.put_rows(index.data(), pairs); });
    }
  }
  return true;
}

bool Grid::sort(std::size_t column, ColumnScratch& scratch) {
  const std::size_t size = column_begin_[column + 1] - column_begin_[column];
  if (size < 2) return false;
  sort_column(records_.data() + column_begin_[column], size, along_, scratch.column);
  if (searched_) keep_sorted(column, scratch.column);
  return true;
}

void Grid::keep_sorted(std::size_t column, const Column& sorted) {
  thin_[column].cells = sorted.cells;
  thin_[column].longest = sorted.longest;
  std::copy(sorted.cell_end.begin(), sorted.cell_end.end(),
            cell_end_.begin() + static_cast<std::ptrdiff_t>(thin_[column].first_cell));
  copy_records(sorted, records_.data() + column_begin_[column]);
}

void Grid::search(const Aabb& box, std::uint32_t index, PairSink& sink) const {
  if (use_tree()) tree_.query(box, index, sink);
  if (crowded_) return;
  if (!use_tree())
    for (const std::uint32_t large : large_)
      if (overlap((*boxes_)[large], box)) sink.put(index, large);
  const Touched t = touched(box);
  for (std::uint32_t v = t.v0; v <= t.v1; ++v) {
    for (std::uint32_t u = t.u0; u <= t.u1; ++u) {
      const std::uint32_t first = (u == t.u0 ? 1u : 0u) | (v == t.v0 ? 2u : 0u);
      const std::size_t column = std::size_t{v} * u_.count + u;
      const ColumnRecord* records = records_.data() + column_begin_[column];
      std::size_t row = 0, end = column_begin_[column + 1] - column_begin_[column];
      if (end > 1) {  // else it was not sorted
        const Thin& thin = thin_[column];
        const std::uint32_t* cell_end = cell_end_.data() + thin.first_cell;
        const std::uint32_t from = thin.cells.at(box.lo[along_]);
        if (from > thin.longest) row = cell_end[from - thin.longest - 1];
        end = cell_end[thin.cells.at(box.hi[along_])];
      }
      // As in a column's kernel: only in the column that holds the lower corner of the intersection.
      for (; row < end; ++row)
        if (overlap(records[row].box, box) && (first | records[row].first) == 3) sink.put(index, records[row].index);
    }
  }
}

void Grid::prefetch(const Aabb& box, Fetch fetch) const {
  if (crowded_) return;
  const Touched t = touched(box);
  for (std::uint32_t v = t.v0; v <= t.v1; ++v) {
    for (std::uint32_t u = t.u0; u <= t.u1; ++u) {
      const std::size_t column = std::size_t{v} * u_.count + u;
      if (fetch == Fetch::index) {
        __builtin_prefetch(&thin_[column]);
        __builtin_prefetch(&column_begin_[column]);
        continue;
      }
      const Thin& thin = thin_[column];
      const std::uint32_t from = thin.cells.at(box.lo[along_]), to = thin.cells.at(box.hi[along_]);
      const std::uint32_t* cell_end = cell_end_.data() + thin.first_cell;
      __builtin_prefetch(cell_end + from - std::min(from, thin.longest + 1));
      __builtin_prefetch(cell_end + to);
      // About as many boxes as cells: where those begin is not known without reading.
      const ColumnRecord* records = records_.data() + column_begin_[column];
      const std::size_t size = column_begin_[column + 1] - column_begin_[column];
      const std::size_t guess =
          size * (from - std::min(from, thin.longest)) / std::max<std::size_t>(1, thin.cells.count);
      for (std::size_t row = guess; row < std::min(size, guess + 12); row += 2) __builtin_prefetch(records + row);
    }
  }
}

std::size_t Grid::memory() const {
  std::size_t bytes = bytes_of(offsets_) + bytes_of(large_of_part_) + bytes_of(role_) + bytes_of(large_) +
                      bytes_of(column_begin_) + bytes_of(groups_) + bytes_of(records_) + bytes_of(thin_) +
                      bytes_of(cell_end_) + tree_.memory() + scratch_.memory() + early_.memory();
  for (const auto& large : large_of_part_) bytes += bytes_of(large);
  return bytes;
}

void Grid::emit_large(std::size_t block, PairSink& sink) const {
  const std::size_t first = block * boxes_a_large_block, last = std::min(size_, first + boxes_a_large_block);
  if (use_tree()) {
    for (std::size_t i = first; i < last; ++i)
      if (role_[i] == Role::entered) tree_.query((*boxes_)[i], static_cast<std::uint32_t>(i), sink);
    return;
  }
  std::vector<std::uint32_t> hits(boxes_a_large_block + BoxArray::padding);
  for (const std::uint32_t large : large_) {
    const std::size_t count = overlap_row(*boxes_, first, last, (*boxes_)[large], hits.data());
    for (std::size_t k = 0; k < count; ++k)
      if (role_[hits[k]] != Role::large || hits[k] > large) sink.put(large, hits[k]);
  }
}

}  // namespace tandem
