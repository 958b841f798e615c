// Sorts candidate pairs into tiles of few bodies, which a pair refers to by two bytes each.
#include "kept_candidates/candidate_tiles.h"

namespace tandem {

TileMaker::TileMaker() {
  table_.fill({});
  buffer_ = room_.data();
  capacity_ = room_.size();
}

void TileMaker::start(const PairFilter& filter, CandidateTiles& tiles) {
  filter_ = &filter;
  tiles_ = &tiles;
  tiles.clear();
  count_ = 0;
  open_tile();
}

void TileMaker::finish() {
  full();
  if (size_ != 0) close_tile(tiles_->candidates.size());
}

void TileMaker::full() {
  std::vector<LocalPair>& candidates = tiles_->candidates;
  std::size_t end = candidates.size();
  candidates.resize(end + count_);
  for (std::size_t k = 0; k < count_; ++k) {
    if (filled()) {
      close_tile(end);
      open_tile();
    }
    const std::uint16_t a = number(buffer_[k].a);
    candidates[end++] = {a, number(buffer_[k].b)};
  }
  count_ = 0;
}

void TileMaker::put_rows(const std::uint32_t* index, std::span<const RowPair> pairs) {
  std::vector<LocalPair>& candidates = tiles_->candidates;
  std::size_t end = candidates.size();
  candidates.resize(end + pairs.size());
  const auto number_of = [&](std::uint32_t row) {
    std::uint16_t& known = number_of_row_[row];
    if (known == no_number) known = number(index[row]);
    return known;
  };
  for (const RowPair pair : pairs) {
    if (!filter_->allows(index[pair.row], index[pair.other])) continue;
    if (filled()) {
      close_tile(end);
      open_tile();
      start_rows(number_of_row_.size());
    }
    const std::uint16_t a = number_of(pair.row);
    candidates[end++] = {a, number_of(pair.other)};
  }
  candidates.resize(end);
}

void TileMaker::open_tile() {
  size_ = 0;
  if (++tile_ != 0) return;
  table_.fill({});
  tile_ = 1;
}

void TileMaker::close_tile(std::size_t candidates_end) {
  tiles_->bodies.insert(tiles_->bodies.end(), bodies_.begin(), bodies_.begin() + static_cast<std::ptrdiff_t>(size_));
  tiles_->tiles.push_back({tiles_->bodies.size(), candidates_end});
}

// The number of a body within the open tile. Whether the body has one already is unpredictable, so that is decided
// without a branch; the only branch is for the rare case that another body occupies its entry of the table.
std::uint16_t TileMaker::number(std::uint32_t body) {
  const std::size_t place = (body * 2654435769u) >> (32 - table_bits);
  const Entry entry = table_[place];
  const bool taken = entry.tile == tile_, known = taken && entry.body == body;
  if (taken && !known) return number_beside(place, body);
  const auto number = static_cast<std::uint16_t>(known ? entry.number : size_);
  table_[place] = {body, tile_, number};
  bodies_[size_] = body;
  size_ += known ? 0 : 1;
  return number;
}

std::uint16_t TileMaker::number_beside(std::size_t place, std::uint32_t body) {
  while (table_[place].tile == tile_) {
    if (table_[place].body == body) return table_[place].number;
    place = (place + 1) % table_.size();
  }
  const auto number = static_cast<std::uint16_t>(size_);
  table_[place] = {body, tile_, number};
  bodies_[size_++] = body;
  return number;
}

}  // namespace tandem
