// Synthetic work for tests of executors and balancing rules.
#pragma once
#include <cstdint>
#include <vector>

#include "tandem/flowgraph/step_work.h"

namespace tandem {

/// Synthetic work to test an executor or a balancing rule with: tiles and pairs that each take a given time, spent in a
/// dependent chain of multiplications. Two thirds of the pairs have an answer, of one contact.
class TileWork final : public StepWork {
 public:
  struct Size {
    std::size_t tiles = 0;
    std::size_t pairs_a_tile = 0;
    double tile_ns = 0;
    double pair_ns = 0;  ///< time of a pair, but for the big ones
    /// One pair in `big_every` takes `big_ns` instead; 0: none does.
    std::size_t big_every = 0;
    double big_ns = 0;
    std::size_t big_from = SIZE_MAX;  ///< all pairs from this one on take big_ns, too
  };
  /// Times must be finite, from 0 to longest_ns, and tiles and pairs a tile together fewer than 2^32 - 1. Throws
  /// std::invalid_argument that names the field, its value and what is allowed.
  explicit TileWork(const Size& size);
  static constexpr double longest_ns = 1e12;
  /// Sets the costs of the following steps, checked as in the constructor; the number of tiles and pairs stays.
  void set_costs(double tile_ns, double pair_ns);

  std::size_t begin() override { return 2; }
  std::size_t blocks(std::size_t stage) const override { return stage == 0 ? 1 : size_.tiles; }
  void run(std::size_t, std::size_t) override {}
  void emit(std::size_t tile, PairSink& sink) override;
  const PairFilter& filter() const override { return filter_; }
  std::size_t keep(std::span<Pair> pairs) const override { return pairs.size(); }
  HeavyPairs heavy_first(std::span<Pair> pairs, std::chrono::nanoseconds batch) const override;
  void narrow(Batch& batch) const override;
  std::size_t bodies() const override { return size_.tiles + size_.pairs_a_tile + 1; }
  std::size_t pairs() const { return size_.tiles * size_.pairs_a_tile; }

 private:
  bool is_big(Pair pair) const;

  Size size_;
  PairFilter filter_;
};

}  // namespace tandem
