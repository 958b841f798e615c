// Searches among the boxes of a step.
#pragma once
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

class TileMaker;

/// Searches of the boxes of a step, possible after the step until the next one begins.
class BoxSearch {
 public:
  /// Announces that this step will be searched; between begin and the last stage.
  virtual void prepare_search() {}
  /// Puts the pair of `index` and each box of the step that overlaps `box`, once; also of `index` with itself.
  virtual void search(const Aabb& box, std::uint32_t index, PairSink& sink) const = 0;
  /// Prefetches what a search of `box` will read: first the index structure, some searches later the boxes.
  enum class Fetch : std::uint8_t { index, boxes };
  virtual void prefetch(const Aabb&, Fetch) const {}
  /// As BroadPhase::emit, but faster for making tiles. Returns false, having done nothing, if the method has no such
  /// function.
  virtual bool emit_tiles(std::size_t, TileMaker&) { return false; }

 protected:
  ~BoxSearch() = default;
};

}  // namespace tandem
