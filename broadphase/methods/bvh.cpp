// The broad phase by a bounding volume hierarchy.
#include "methods/bvh.h"

namespace tandem {

std::size_t Bvh::begin(const BoxArray& boxes) {
  tree_.begin(boxes, nullptr);
  return BoxTree::build_stages + 1;
}

std::size_t Bvh::blocks(std::size_t stage) const {
  return stage < BoxTree::build_stages ? tree_.blocks(stage) : tree_.self_blocks();
}

}  // namespace tandem
