#pragma once
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

class TileMaker;

/// What can be searched for a box after a step, until the next one begins.
class BoxSearch {
 public:
  /// Between begin and the last stage: this step will be searched.
  virtual void prepare_search() {}
  /// Puts the pair of `index` and each box of the step that overlaps `box`, once; also that of `index` itself.
  virtual void search(const Aabb& box, std::uint32_t index, PairSink& sink) const = 0;
  /// Asks the caches for what a search of `box` will read: where to look; some searches later the boxes there.
  enum class Fetch : std::uint8_t { index, boxes };
  virtual void prefetch(const Aabb&, Fetch) const {}
  /// As BroadPhase::emit, in a way that is faster for tiles. False where there is none, nothing is done then.
  virtual bool emit_tiles(std::size_t, TileMaker&) { return false; }

 protected:
  ~BoxSearch() = default;
};

}  // namespace tandem
