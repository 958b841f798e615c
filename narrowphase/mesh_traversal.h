#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "mesh_model.h"
#include "predicates.h"

namespace tandem {

/// Simultaneous traversal of two hierarchies: calls visit(i, j) for every triangle i of `a` and j of `b` that may meet,
/// never leaving one out that does, in an order that depends on the arguments only, the same j in a row. Stops when
/// visit returns true. Boxes are compared along the axes of both meshes. Wants a.unit >= b.unit.
class MeshTraversal {
 public:
  MeshTraversal(const MeshModel& a, const MeshModel& b, const TriangleTest& frame) : a_(a), b_(b) {
    const double ratio = b.unit / a.unit;
    const Mat3 inverse = frame.map().inverse();
    const Vec3 between = (frame.map() * b.centre + (frame.shift() - a.centre)) / a.unit;
    // Coordinates in the boxes are at most 1, so that everything that can meet stays below 8 and floats are off by less
    // than 4e-6 in all.
    pad_ = static_cast<float>(4e-6 + 4 * frame.delta() / a.unit);
    apart_ = !(between.cwiseAbs().maxCoeff() < 4);
    for (int i = 0; i < 3; ++i) {
      shift_[i] = apart_ ? 0 : static_cast<float>(between[i]);
      for (int j = 0; j < 3; ++j) {
        scaled_[i][j] = static_cast<float>(frame.map()(i, j) * ratio);
        inverse_[i][j] = static_cast<float>(inverse(i, j));
      }
    }
    ratio_ = static_cast<float>(ratio);
  }

  template <class Visit>
  void operator()(Visit&& visit) const {
    if (apart_) return;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> stack;
    stack.reserve(128);
    stack.emplace_back(0, 0);
    while (!stack.empty()) {
      const auto [ra, rb] = stack.back();
      stack.pop_back();
      if (is_leaf(ra) && is_leaf(rb)) {
        const auto [first_a, last_a] = triangles(a_, ra);
        const auto [first_b, last_b] = triangles(b_, rb);
        for (std::uint32_t j = first_b; j < last_b; ++j)
          for (std::uint32_t i = first_a; i < last_a; ++i)
            if (visit(a_.order[i], b_.order[j])) return;
        continue;
      }
      const MeshNode& nb = b_.nodes[node_of(rb)];
      const Lanes mapped = map(nb);
      if (is_leaf(ra)) {
        const Lanes box = lane(a_.nodes[node_of(ra)], ra & 3);
        const auto worst = gap(box, mapped, half(nb));
        for (std::uint32_t k = 0; k < nb.lanes; ++k)
          if (worst[k] <= 0) stack.emplace_back(ra, child(nb, node_of(rb), k));
        continue;
      }
      const MeshNode& na = a_.nodes[ra];
      const Lanes boxes = lanes(na);
      const std::uint32_t begin = is_leaf(rb) ? rb & 3 : 0, end = is_leaf(rb) ? begin + 1 : nb.lanes;
      for (std::uint32_t j = begin; j < end; ++j) {
        const auto worst = gap(boxes, lane(mapped, j), lane(half(nb), j));
        const std::uint32_t next_b = is_leaf(rb) ? rb : child(nb, rb, j);
        for (std::uint32_t k = 0; k < na.lanes; ++k)
          if (worst[k] <= 0) stack.emplace_back(child(na, ra, k), next_b);
      }
    }
  }

 private:
  using Four = Eigen::Array<float, 4, 1>;
  struct Halves {
    Four axis[3];
  };
  struct Lanes {
    Four mid[3];
    Four half[3];
  };

  // A reference is an inner node's index, or a leaf's node and lane with the top bit set.
  static constexpr std::uint32_t leaf_bit = 0x80000000u;
  static bool is_leaf(std::uint32_t r) { return (r & leaf_bit) != 0; }
  static std::uint32_t node_of(std::uint32_t r) { return is_leaf(r) ? (r & ~leaf_bit) >> 2 : r; }
  static std::uint32_t child(const MeshNode& node, std::uint32_t index, std::uint32_t k) {
    return node.count[k] > 0 ? leaf_bit | (index << 2) | k : node.child[k];
  }
  static std::pair<std::uint32_t, std::uint32_t> triangles(const MeshModel& mesh, std::uint32_t r) {
    const MeshNode& node = mesh.nodes[node_of(r)];
    return {node.child[r & 3], node.child[r & 3] + node.count[r & 3]};
  }

  static Four load(const float* p) { return Eigen::Map<const Four, Eigen::Aligned16>(p); }
  static Lanes lanes(const MeshNode& n) {
    return {{load(n.mid[0]), load(n.mid[1]), load(n.mid[2])}, {load(n.half[0]), load(n.half[1]), load(n.half[2])}};
  }
  static Halves half(const MeshNode& n) { return {{load(n.half[0]), load(n.half[1]), load(n.half[2])}}; }
  static Lanes lane(const MeshNode& n, std::uint32_t k) {
    Lanes r;
    for (int i = 0; i < 3; ++i) r.mid[i].setConstant(n.mid[i][k]), r.half[i].setConstant(n.half[i][k]);
    return r;
  }
  static Lanes lane(const Lanes& l, std::uint32_t k) {
    Lanes r;
    for (int i = 0; i < 3; ++i) r.mid[i].setConstant(l.mid[i][k]), r.half[i].setConstant(l.half[i][k]);
    return r;
  }
  static Halves lane(const Halves& h, std::uint32_t k) {
    Halves r;
    for (int i = 0; i < 3; ++i) r.axis[i].setConstant(h.axis[i][k]);
    return r;
  }

  // B's four boxes in A's frame: middles, and halves of the boxes around them along A's axes.
  Lanes map(const MeshNode& n) const {
    const Lanes b = lanes(n);
    Lanes r;
    for (int i = 0; i < 3; ++i) {
      const float x = scaled_[i][0], y = scaled_[i][1], z = scaled_[i][2];
      r.mid[i] = x * b.mid[0] + y * b.mid[1] + z * b.mid[2] + shift_[i];
      r.half[i] = std::abs(x) * b.half[0] + std::abs(y) * b.half[1] + std::abs(z) * b.half[2] + pad_;
    }
    return r;
  }

  // Largest gap along the three axes of A and the three of B; `half_b` as stored, along B's own axes.
  Four gap(const Lanes& a, const Lanes& b, const Halves& half_b) const {
    const Four d[3] = {a.mid[0] - b.mid[0], a.mid[1] - b.mid[1], a.mid[2] - b.mid[2]};
    Four worst = d[0].abs() - (a.half[0] + b.half[0]);
    worst = worst.max(d[1].abs() - (a.half[1] + b.half[1]));
    worst = worst.max(d[2].abs() - (a.half[2] + b.half[2]));
    for (int j = 0; j < 3; ++j) {
      const float x = inverse_[j][0], y = inverse_[j][1], z = inverse_[j][2];
      const Four along = x * d[0] + y * d[1] + z * d[2];
      const Four reach = std::abs(x) * a.half[0] + std::abs(y) * a.half[1] + std::abs(z) * a.half[2];
      worst = worst.max(along.abs() - (reach + (ratio_ * half_b.axis[j] + 2 * pad_)));
    }
    return worst;
  }

  const MeshModel& a_;
  const MeshModel& b_;
  float scaled_[3][3], inverse_[3][3], shift_[3], ratio_, pad_;
  bool apart_;
};

}  // namespace tandem
