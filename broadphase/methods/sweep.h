// The broad phase `sweep`: sweep and prune along one axis.
#pragma once
#include "methods/listed_method.h"
#include "storage/memory.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// Sweep and prune along one axis, from scratch in each step (Baraff 1992; Cohen et al., I-COLLIDE, 1995): boxes are
/// sorted by their lower bound on the axis along which they are spread most, and each is tested against the following
/// boxes that begin before it ends. Sorting is a parallel merge sort of fixed chunks, ties broken by index.
class Sweep final : public ListedMethod {
 public:
  std::size_t begin(const BoxArray& boxes) override;
  std::size_t blocks(std::size_t stage) const override;
  void run(std::size_t stage, std::size_t block) override;
  void emit(std::size_t block, PairSink& sink) override;
  BroadPhaseKind kind() const override { return BroadPhaseKind::sweep; }
  MethodCosts costs(std::size_t boxes) const override {
    const auto n = static_cast<double>(boxes);
    return {90 + 0.03 * n, 25, 150 + 0.03 * n, 38};
  }
  std::size_t memory() const override {
    return bytes_of(spread_) + bytes_of(keys_) + bytes_of(merged_) + bytes_of(order_) + sorted_.memory();
  }

 private:
  static constexpr std::size_t chunk = 2048;  // boxes of a block that measures the spread, sorts, merges or gathers
  static constexpr std::size_t rows_a_block = 64;
  struct Spread {
    std::array<double, 3> sum{}, sum_of_squares{};
    double count = 0;
  };

  void measure(std::size_t block);
  void sort_chunk(std::size_t block);
  void merge(std::size_t round, std::size_t block);
  void gather(std::size_t block);
  int axis() const;

  const BoxArray* boxes_ = nullptr;
  std::size_t size_ = 0;
  std::size_t merge_rounds_ = 0;
  std::vector<Spread> spread_;                // one a block
  std::vector<std::uint64_t> keys_, merged_;  // ordered lower bound in the high half, index in the low half
  std::vector<std::uint32_t> order_;
  BoxArray sorted_;
};

}  // namespace tandem
