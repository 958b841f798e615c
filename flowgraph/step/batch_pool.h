// A pool of batches.
#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// A pool of batches, kept from step to step. Taking a batch is an atomic increment unless the pool has to grow.
class BatchPool {
 public:
  void begin(std::size_t batch_pairs);
  Batch& take();
  /// All batches taken since begin(); not while some thread may take one.
  std::span<Batch* const> taken();
  bool grew() const { return !grown_.empty(); }
  std::size_t memory() const;  ///< not while some thread may take one

 private:
  std::size_t batch_pairs_ = 0;
  std::vector<std::unique_ptr<Batch>> batches_, grown_;
  std::vector<Batch*> taken_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
};

}  // namespace tandem
