// Tiles of candidate pairs.
#include "kept_candidates/candidate_tiles.h"

#include <algorithm>
#include <random>

#include "catch.h"

using namespace tandem;

namespace {

std::uint32_t draw(std::mt19937& random, std::size_t below) { return static_cast<std::uint32_t>(random() % below); }

std::vector<Pair> pairs_of(const CandidateTiles& tiles) {
  std::vector<Pair> pairs;
  std::size_t first_body = 0, first = 0;
  for (const CandidateTiles::Tile& tile : tiles.tiles) {
    const std::size_t count = tile.bodies_end - first_body;
    CHECK(count <= CandidateTiles::most_bodies);
    std::vector<std::uint32_t> bodies(tiles.bodies.begin() + static_cast<std::ptrdiff_t>(first_body),
                                      tiles.bodies.begin() + static_cast<std::ptrdiff_t>(tile.bodies_end));
    for (; first < tile.candidates_end; ++first) {
      const LocalPair pair = tiles.candidates[first];
      REQUIRE(std::max(pair.a, pair.b) < count);
      pairs.push_back({bodies[pair.a], bodies[pair.b]});
    }
    std::sort(bodies.begin(), bodies.end());
    CHECK(std::adjacent_find(bodies.begin(), bodies.end()) == bodies.end());
    first_body = tile.bodies_end;
  }
  CHECK(first == tiles.candidates.size());
  CHECK(first_body == tiles.bodies.size());
  return pairs;
}

}  // namespace

TEST_CASE("candidate tiles: give back what was put, in its order, a body once a tile") {
  std::mt19937 random(3);
  const PairFilter everything;
  CandidateTiles tiles;
  TileMaker maker;
  // Few bodies that recur, and so many that tiles are closed in between; numbers whose places in the table collide.
  for (const auto& [bodies, stride] : {std::pair{5u, 1u}, {1000u, 1u}, {100'000u, 1u}, {5000u, 4096u}})
    for (const std::size_t count : {0u, 1u, 255u, 256u, 20'000u}) {
      CAPTURE(bodies, stride, count);
      std::vector<Pair> put;
      maker.start(everything, tiles);
      while (put.size() < count) {
        const std::uint32_t a = draw(random, bodies) * stride, b = draw(random, bodies) * stride;
        if (a == b) continue;
        maker.put(a, b);
        put.push_back({std::min(a, b), std::max(a, b)});
      }
      maker.finish();
      CHECK(pairs_of(tiles) == put);
      if (count == 20'000 && bodies > 4096) CHECK(tiles.tiles.size() > 1);
    }
}

TEST_CASE("candidate tiles: rows stand for bodies, the filter says which pairs there are") {
  std::mt19937 random(4);
  std::vector<std::uint8_t> is_static(100'000);
  for (std::size_t i = 0; i < is_static.size(); ++i) is_static[i] = i % 3 == 0;
  const PairFilter filter{{}, {}, is_static};
  CandidateTiles tiles;
  TileMaker maker;
  maker.start(filter, tiles);
  std::vector<Pair> expected;
  for (const std::size_t rows : {10u, 3000u, 1u, 20'000u}) {
    std::vector<std::uint32_t> index(rows);
    for (std::uint32_t& body : index) body = draw(random, is_static.size());
    maker.start_rows(rows);
    std::vector<RowPair> pairs;
    for (std::size_t k = 0; k < 2 * rows; ++k) {
      const std::uint32_t a = draw(random, rows), b = draw(random, rows);
      if (index[a] == index[b]) continue;
      pairs.push_back({a, b});
      if (filter.allows(index[a], index[b])) expected.push_back({index[a], index[b]});
    }
    const auto half = static_cast<std::ptrdiff_t>(pairs.size() / 2);
    maker.put_rows(index.data(), {pairs.begin(), pairs.begin() + half});
    maker.put_rows(index.data(), {pairs.begin() + half, pairs.end()});
  }
  maker.finish();
  CHECK(pairs_of(tiles) == expected);
  CHECK(tiles.tiles.size() > 3);
}

TEST_CASE("column hits: bits become pairs in their order") {
  std::mt19937 random(5);
  std::vector<RowHits> hits;
  std::vector<RowPair> expected;
  for (std::uint32_t k = 0; k < 300; ++k) {
    hits.push_back({k, k + 1, draw(random, k % 2 == 0 ? 0x100 : 0x10000) & draw(random, 0x10000)});
    for (std::uint32_t bit = 0; bit < 32; ++bit)
      if ((hits.back().bits >> bit & 1) != 0) expected.push_back({k, k + 1 + bit});
  }
  std::vector<RowPair> found(16 * hits.size());
  found.resize(pairs_of_hits(hits.data(), hits.size(), found.data()));
  REQUIRE(found.size() == expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    CHECK(found[k].row == expected[k].row);
    CHECK(found[k].other == expected[k].other);
  }
}
