#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem {

/// Nodes of two hierarchies that are to be traversed together.
struct NodePair {
  std::uint32_t a, b;
};

/// Nearly always shallow; only deep trees of great meshes need the heap.
class NodePairStack {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  void push(NodePair p) {
    if (size_ < near_.size())
      near_[size_] = p;
    else
      far_.push_back(p);
    ++size_;
  }
  NodePair pop() {
    --size_;
    if (size_ < near_.size()) return near_[size_];
    const NodePair p = far_.back();
    far_.pop_back();
    return p;
  }
  NodePair& operator[](std::size_t i) { return i < near_.size() ? near_[i] : far_[i - near_.size()]; }

 private:
  std::size_t size_ = 0;
  std::array<NodePair, 512> near_;
  std::vector<NodePair> far_;
};

}  // namespace tandem
