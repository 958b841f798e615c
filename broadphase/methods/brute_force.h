// The broad phase `brute`: all pairs of boxes.
#pragma once
#include "methods/listed_method.h"
#include "storage/memory.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// The broad phase of Avril, Gouranton and Arnaldi (ICAT 2010, section 3.2): all n(n-1)/2 pairs of boxes, in every step
/// from scratch. The upper triangle of the pair matrix is cut into independent tiles. Cost n^2; the reference for the
/// other methods.
class BruteForce final : public ListedMethod {
 public:
  std::size_t begin(const BoxArray& boxes) override;
  std::size_t blocks(std::size_t) const override { return tiles_.size(); }
  void run(std::size_t, std::size_t) override {}  // not called: the only stage is the last
  void emit(std::size_t block, PairSink& sink) override;
  BroadPhaseKind kind() const override { return BroadPhaseKind::brute; }
  std::size_t memory() const override { return bytes_of(tiles_); }
  MethodCosts costs(std::size_t boxes) const override {
    const auto n = static_cast<double>(boxes);
    return {28 + 0.11 * n, 10, 80 + 0.11 * n, 25};
  }

 private:
  // A tile is about 10 us of work with 8 lanes; its columns (24 KiB of bounds) stay in the first-level cache.
  static constexpr std::uint32_t tile_rows = 64;
  static constexpr std::uint32_t tile_columns = 1024;
  struct Tile {
    std::uint32_t row, column;
  };
  const BoxArray* boxes_ = nullptr;
  std::size_t size_ = 0;
  std::vector<Tile> tiles_;
};

}  // namespace tandem
