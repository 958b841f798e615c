// Pairs of triangles with near boxes, by a simultaneous traversal.
#include "meshes/traversal/near_triangles.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lanes/four_floats.h"
#include "shapes/shape_insides.h"
#include "shapes/skewness.h"
#include "tolerances.h"

namespace tandem {
namespace {

using Lanes = FourFloats;
constexpr std::size_t wanted_subtrees = 512;

// The lanes of a node, unused ones included, that are within half sizes `half` of a box along every axis.
std::uint32_t lanes_near(const LaneBoxes& boxes, const float (&mid)[3], const float (&half)[3]) {
  std::uint32_t near = 0;
  for (std::size_t l = 0; l < mesh_lanes; l += 4) {
    Lanes gap = all_four(-1);
    for (int axis = 0; axis < 3; ++axis)
      gap = max_of(gap, absolute(load_four(boxes.mid[axis] + l) - all_four(mid[axis])) -
                            (load_four(boxes.half[axis] + l) + all_four(half[axis])));
    for (int k = 0; k < 4; ++k) near |= (gap[k] <= 0 ? 1u : 0u) << (static_cast<int>(l) + k);
  }
  return near;
}

}  // namespace

// The boxes of a node of B in A's frame; half sizes enlarged by the margin.
struct NearBoxPairs::Boxes {
  float mid[mesh_lanes][3], half[mesh_lanes][3];
};

NearBoxPairs::NearBoxPairs(const MeshModel& mesh, double margin)
    : a_(mesh),
      b_(mesh),
      self_(true),
      map_{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
      shift_{0, 0, 0},
      pad_(static_cast<float>((margin / mesh.unit + 2 * tolerance::box_of_floats) * (1 + tolerance::box_of_floats))) {}

NearBoxPairs::NearBoxPairs(const Posed& a, const Posed& b, double margin)
    : a_(mesh_of(a.shape)), b_(mesh_of(b.shape)), self_(false) {
  const Mat3 turn = a.pose.rotation.transpose() * b.pose.rotation;
  const Vec3 between = a.pose.rotation.transpose() * (b.pose.translation - a.pose.translation);
  const Vec3 shift = (turn * b_.centre + between - a_.centre) / a_.unit;
  const double scale = b_.unit / a_.unit;
  for (int i = 0; i < 3; ++i) {
    shift_[i] = static_cast<float>(shift[i]);
    for (int j = 0; j < 3; ++j) map_[i][j] = static_cast<float>(turn(i, j) * scale);
  }
  // Rotations need not be exactly orthonormal.
  const double off = 4 * tolerance::box_of_floats + 4 * (skewness(a.pose.rotation) + skewness(b.pose.rotation));
  pad_ = static_cast<float>((margin / a_.unit + off * (1 + scale + shift.cwiseAbs().maxCoeff())) *
                            (1 + tolerance::box_of_floats));
}

void NearBoxPairs::map(const LaneBoxes& given, std::uint32_t lanes, Boxes& out) const {
  for (std::uint32_t k = 0; k < lanes; ++k)
    for (int i = 0; i < 3; ++i) {
      if (self_) {
        out.mid[k][i] = given.mid[i][k];
        out.half[k][i] = given.half[i][k] + pad_;
        continue;
      }
      out.mid[k][i] =
          map_[i][0] * given.mid[0][k] + map_[i][1] * given.mid[1][k] + map_[i][2] * given.mid[2][k] + shift_[i];
      out.half[k][i] = std::abs(map_[i][0]) * given.half[0][k] + std::abs(map_[i][1]) * given.half[1][k] +
                       std::abs(map_[i][2]) * given.half[2][k] + pad_;
    }
}

void NearBoxPairs::descend(NodePair at, std::vector<NodePair>& out) const {
  const MeshNode &na = a_.nodes[at.a], &nb = b_.nodes[at.b];
  Boxes boxes;
  if (na.bottom()) {  // B's lanes against A's whole node
    const ChildBoxes& of_b = b_.boxes_of(nb);
    map(of_b, nb.lanes(), boxes);
    for (std::uint32_t j = 0; j < nb.lanes(); ++j) {
      bool near = true;
      for (int i = 0; i < 3; ++i)
        near = near && std::abs(na.box_mid[i] - boxes.mid[j][i]) - (na.box_half[i] + boxes.half[j][i]) <= 0;
      if (near) out.push_back({at.a, of_b.child[j]});
    }
    return;
  }
  const ChildBoxes& of_a = a_.boxes_of(na);
  if (nb.bottom()) {
    LaneBoxes one;
    for (int i = 0; i < 3; ++i) one.mid[i][0] = nb.box_mid[i], one.half[i][0] = nb.box_half[i];
    map(one, 1, boxes);
    for (std::uint32_t near = lanes_near(of_a, boxes.mid[0], boxes.half[0]) & na.used(); near != 0; near &= near - 1)
      out.push_back({of_a.child[std::countr_zero(near)], at.b});
    return;
  }
  const ChildBoxes& of_b = b_.boxes_of(nb);
  map(of_b, nb.lanes(), boxes);
  for (std::uint32_t j = 0; j < nb.lanes(); ++j) {
    std::uint32_t near = lanes_near(of_a, boxes.mid[j], boxes.half[j]) & na.used();
    if (self_ && at.a == at.b) near &= (2u << j) - 1;  // each pair once, and each child with itself
    for (; near != 0; near &= near - 1) out.push_back({of_a.child[std::countr_zero(near)], of_b.child[j]});
  }
}

bool NearBoxPairs::visit_bottom(NodePair at, PairVisitor& visitor) const {
  const MeshNode &na = a_.nodes[at.a], &nb = b_.nodes[at.b];
  LaneBoxes boxes_a, boxes_b;
  a_.boxes_of_triangles(na, boxes_a);
  b_.boxes_of_triangles(nb, boxes_b);
  Boxes boxes;
  map(boxes_b, nb.lanes(), boxes);
  for (std::uint32_t j = 0; j < nb.lanes(); ++j) {
    std::uint32_t near = lanes_near(boxes_a, boxes.mid[j], boxes.half[j]) & na.used();
    if (self_ && at.a == at.b) near &= (1u << j) - 1;
    const std::uint32_t of_b = b_.triangle_of(nb, j);
    for (; near != 0; near &= near - 1) {
      const std::uint32_t of_a = a_.triangle_of(na, static_cast<std::uint32_t>(std::countr_zero(near)));
      if (self_ ? visitor.visit(std::min(of_a, of_b), std::max(of_a, of_b)) : visitor.visit(of_a, of_b)) return true;
    }
  }
  return false;
}

std::vector<NodePair> NearBoxPairs::subtrees() const {
  return pairs_of_level(a_, b_, wanted_subtrees,
                        [this](NodePair at, std::vector<NodePair>& next) { descend(at, next); });
}

void NearBoxPairs::visit(NodePair subtrees, PairVisitor& visitor) const {
  std::vector<NodePair> stack{subtrees};
  while (!stack.empty()) {
    const NodePair at = stack.back();
    stack.pop_back();
    visitor.meter.spend();
    if (!a_.nodes[at.a].bottom() || !b_.nodes[at.b].bottom())
      descend(at, stack);
    else if (visit_bottom(at, visitor))
      return;
  }
}

SearchEnd visit_in_turn(const NearBoxPairs& near, PairVisitor& visitor, const SearchOptions& options,
                        const std::function<bool()>& ended) {
  constexpr std::size_t times = 100;  // reports of progress at most
  try {
    visitor.meter.spend();
    const std::vector<NodePair> subtrees = near.subtrees();
    for (std::size_t k = 0; k < subtrees.size(); ++k) {
      near.visit(subtrees[k], visitor);
      if (ended()) return SearchEnd::by_visitor;
      if (options.progress && (k + 1) * times / subtrees.size() > k * times / subtrees.size() &&
          k + 1 < subtrees.size())
        options.progress(static_cast<double>(k + 1) / static_cast<double>(subtrees.size()));
    }
  } catch (const WorkStopped&) {
    return SearchEnd::stopped;
  }
  if (options.progress) options.progress(1);
  return SearchEnd::done;
}

}  // namespace tandem
