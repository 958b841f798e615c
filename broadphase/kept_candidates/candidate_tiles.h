// Compact storage of candidate pairs.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/box_record.h"
#include "kernels/column_kernel.h"
#include "storage/memory.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// Candidate pairs in tiles of few bodies, which are numbered within their tile: the boxes of a tile are fetched once
/// and stay in the first-level caches, and a pair takes four bytes.
struct CandidateTiles {
  static constexpr std::size_t most_bodies = 2048;  ///< bodies of a tile

  struct Tile {
    std::size_t bodies_end, candidates_end;
  };
  std::vector<std::uint32_t> bodies;
  std::vector<LocalPair> candidates;
  std::vector<Tile> tiles;

  void clear() {
    bodies.clear();
    candidates.clear();
    tiles.clear();
  }
  /// Copies `other`, and releases memory if this list's is far too large for it.
  void assign(const CandidateTiles& other) {
    const auto take = [](auto& values, const auto& from) {
      values.assign(from.begin(), from.end());
      if (values.capacity() > 64 + 2 * values.size()) values.shrink_to_fit();
    };
    take(bodies, other.bodies);
    take(candidates, other.candidates);
    take(tiles, other.tiles);
  }
  void append(const CandidateTiles& other) {
    const std::size_t first_body = bodies.size(), first = candidates.size();
    bodies.insert(bodies.end(), other.bodies.begin(), other.bodies.end());
    candidates.insert(candidates.end(), other.candidates.begin(), other.candidates.end());
    for (const Tile& tile : other.tiles) tiles.push_back({first_body + tile.bodies_end, first + tile.candidates_end});
  }
  std::size_t memory() const { return bytes_of(bodies) + bytes_of(candidates) + bytes_of(tiles); }
};

/// Takes candidate pairs, in any order, and makes tiles of them: pairs that are put one after the other share a tile.
class TileMaker final : public PairSink {
 public:
  TileMaker();
  /// From now on takes the pairs that `filter` allows and adds them to `tiles`, until `finish`. Both must live as long.
  void start(const PairFilter& filter, CandidateTiles& tiles);
  void finish();

  /// Takes pairs of rows, each of which stands for a body: index[row]. Until the next start there are `count` rows,
  /// always the same.
  void start_rows(std::size_t count) { number_of_row_.assign(count, no_number); }
  void put_rows(const std::uint32_t* index, std::span<const RowPair> pairs);
  std::size_t memory() const { return bytes_of(number_of_row_); }

 private:
  static constexpr std::uint16_t no_number = 0xffff;
  static constexpr int table_bits = 12;  // twice as many places as a tile has bodies

  /// An entry of the hash table: a body with its number in a tile; stale if the tile is not the open one.
  struct Entry {
    std::uint32_t body;
    std::uint16_t tile, number;
  };

  void full() override;
  void open_tile();
  void close_tile(std::size_t candidates_end);
  /// True if the tile has no room for another pair.
  bool filled() const { return size_ + 2 > CandidateTiles::most_bodies; }
  std::uint16_t number(std::uint32_t body);
  std::uint16_t number_beside(std::size_t place, std::uint32_t body);

  CandidateTiles* tiles_ = nullptr;
  std::size_t size_ = 0;    // bodies of the open tile
  std::uint16_t tile_ = 0;  // number of the open tile, never 0
  std::array<Pair, 256> room_;
  std::vector<std::uint16_t> number_of_row_;
  std::array<std::uint32_t, CandidateTiles::most_bodies + 1> bodies_;
  std::array<Entry, std::size_t{1} << table_bits> table_;  // open addressing
};

}  // namespace tandem
