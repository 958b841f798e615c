// Synthetic tiles and pairs that take given times.
#include "tandem/flowgraph/tile_work.h"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <stdexcept>
#include <string>

namespace tandem {
namespace {

std::uint64_t chain(std::uint64_t links) {
  std::uint64_t x = links | 1;
  for (std::uint64_t i = 0; i < links; ++i) x = x * 0x9e3779b97f4a7c15u + 1;
  return x;
}

/// Keeps the compiler from leaving out the computation of `value`. It is stored nowhere: a cache line that all threads
/// write would distort the measurement.
void use(std::uint64_t value) { asm volatile("" : : "r"(value)); }

/// Links of the chain of multiplications that take a nanosecond, measured once.
double links_a_ns() {
  static const double rate = [] {
    constexpr std::uint64_t links = 200'000;
    double least = 1e300;
    for (int i = 0; i < 20; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      use(chain(links));
      least =
          std::min(least, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count());
    }
    return static_cast<double>(links) / least;
  }();
  return rate;
}

void spend(double ns) {
  if (ns > 0) use(chain(static_cast<std::uint64_t>(ns * links_a_ns())));
}

void require_time(const char* field, double ns) {
  if (ns >= 0 && ns <= TileWork::longest_ns) return;
  std::ostringstream message;
  message.precision(17);
  message << "tile_work: " << field << " is " << ns << ", allowed: 0 to "
          << static_cast<std::int64_t>(TileWork::longest_ns) << " ns";
  throw std::invalid_argument(message.str());
}

}  // namespace

TileWork::TileWork(const Size& size) : size_(size) {
  require_time("tile_ns", size.tile_ns);
  require_time("pair_ns", size.pair_ns);
  require_time("big_ns", size.big_ns);
  constexpr std::size_t most = 0xfffffffeu;  // body indices have 32 bits
  if (size.tiles > most || size.pairs_a_tile > most - size.tiles)
    throw std::invalid_argument("tile_work: tiles and pairs_a_tile are " + std::to_string(size.tiles) + " and " +
                                std::to_string(size.pairs_a_tile) + ", allowed: fewer than 4294967295 together");
}

void TileWork::set_costs(double tile_ns, double pair_ns) {
  require_time("tile_ns", tile_ns);
  require_time("pair_ns", pair_ns);
  size_.tile_ns = tile_ns;
  size_.pair_ns = pair_ns;
}

void TileWork::emit(std::size_t tile, PairSink& sink) {
  const double ns = size_.pairs_a_tile > 0 ? size_.tile_ns / static_cast<double>(size_.pairs_a_tile) : 0;
  if (size_.pairs_a_tile == 0) return spend(size_.tile_ns);
  for (std::size_t i = 0; i < size_.pairs_a_tile; ++i) {
    spend(ns);
    sink.put(static_cast<std::uint32_t>(tile), static_cast<std::uint32_t>(tile + 1 + i));
  }
}

bool TileWork::is_big(Pair pair) const {
  const std::size_t index = pair.a * size_.pairs_a_tile + pair.b - pair.a - 1;
  return index >= size_.big_from || (size_.big_every != 0 && index % size_.big_every == 0);
}

HeavyPairs TileWork::heavy_first(std::span<Pair> pairs, std::chrono::nanoseconds) const {
  if (size_.big_ns == 0) return {};
  const auto middle = std::partition(pairs.begin(), pairs.end(), [this](Pair pair) { return is_big(pair); });
  return {0, static_cast<std::size_t>(middle - pairs.begin())};
}

void TileWork::narrow(Batch& batch) const {
  for (const Pair pair : std::span(batch.pairs).first(batch.count)) {
    spend(is_big(pair) ? size_.big_ns : size_.pair_ns);
    if ((pair.a + pair.b) % 3 == 0) continue;
    PairResult result{pair.a, pair.b, static_cast<std::uint32_t>(batch.contacts.size()), 1, {}};
    result.answer.collide = true;
    batch.contacts.push_back({Vec3(pair.a, pair.b, 0), Vec3::UnitZ(), 1.0 / (1 + pair.a + pair.b), 0});
    batch.results.push_back(result);
  }
}

}  // namespace tandem
