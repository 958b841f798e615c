// Splits by the surface area heuristic over bins of the centroids (Wald, On fast construction of SAH-based bounding volume
// hierarchies, 2007), eight children a node. Boxes to split by are floats, which move with their triangles; boxes of nodes
// are put together from the corners on the return.
#include "shapes/mesh_hierarchy.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "lanes/four_floats.h"
#include "tolerances.h"

namespace tandem {
namespace {
using Lanes = FourFloats;  // x, y, z and one more, which is 0

constexpr int bins = 16;
// Below this, splits are by the median, so that no input makes the tree deeper than this plus log2 of its triangles.
constexpr int last_binned_level = 24;
// Subtrees of more triangles are shared between threads.
constexpr std::uint32_t shared_above = 16'384;

constexpr float far_away = std::numeric_limits<float>::infinity();

// A triangle's box, in units of the mesh about its centre.
struct alignas(32) Reference {
  float low[3];
  std::uint32_t triangle;
  float high[4];

  Lanes lower() const { return Lanes{low[0], low[1], low[2], 0}; }
  Lanes upper() const { return load_four(high); }
  Lanes centre() const { return lower() + upper(); }  // twice: only compared
};

struct FlatBox {
  Lanes low = all_four(far_away), high = all_four(-far_away);

  void add(Lanes l, Lanes h) { low = min_of(low, l), high = max_of(high, h); }
  void add(const FlatBox& b) { add(b.low, b.high); }
  float half_area() const {
    const Lanes s = max_of(high - low, all_four(0));
    return s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
  }
};

// Triangles begin ... end of the order, and where their centroids lie.
struct Range {
  std::uint32_t begin = 0, end = 0;
  FlatBox centres{};
  std::uint32_t size() const { return end - begin; }
};

// What a subtree holds: its box, and the spread of its corners about their mean.
struct Content {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  double corners = 0;
  Vec3 mean = Vec3::Zero();
  Mat3 spread = Mat3::Zero();  // the lower triangle

  void add(const Content& o) {
    low = low.cwiseMin(o.low), high = high.cwiseMax(o.high);
    // Chan, Golub and LeVeque, Updating formulae and a pairwise algorithm for computing sample variances, 1979.
    const double all = corners + o.corners, weight = corners * o.corners / all;
    const Vec3 apart = o.mean - mean;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) spread(i, j) += o.spread(i, j) + weight * apart[i] * apart[j];
    mean += o.corners / all * apart;
    corners = all;
  }
};

// Where to part a range: before a bin along an axis.
struct Split {
  int axis = -1, bin = 0;
  float cost = std::numeric_limits<float>::infinity();
};

// Bins along the three axes at once.
class Binning {
 public:
  explicit Binning(const FlatBox& centres) : low_(centres.low) {
    const Lanes width = centres.high - centres.low;
    for (int axis = 0; axis < 4; ++axis) scale_[axis] = width[axis] > least_width ? bins / width[axis] : 0;
  }
  bool sorts(int axis) const { return scale_[axis] > 0; }

  std::array<std::int32_t, 4> bins_of(const Reference& r) const {
    return to_integers(min_of((r.centre() - low_) * scale_, all_four(bins - 1)));
  }

  Split best(const Reference* from, const Reference* to) const {
    FlatBox box[3][bins];
    std::uint32_t count[3][bins] = {};
    for (const Reference* r = from; r != to; ++r) {
      const auto bin = bins_of(*r);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box[axis][bin[axis]].add(r->lower(), r->upper());
        ++count[axis][bin[axis]];
      }
    }
    Split split;
    for (int axis = 0; axis < 3; ++axis)
      if (sorts(axis)) improve(axis, box[axis], count[axis], static_cast<std::uint32_t>(to - from), split);
    return split;
  }

 private:
  static void improve(int axis, const FlatBox* box, const std::uint32_t* count, std::uint32_t all, Split& split) {
    float right[bins];
    FlatBox sum;
    std::uint32_t n = 0;
    for (int b = bins - 1; b > 0; --b) {
      sum.add(box[b]);
      n += count[b];
      right[b] = n > 0 ? sum.half_area() * static_cast<float>(n) : 0;
    }
    sum = {};
    n = 0;
    for (int b = 1; b < bins; ++b) {
      sum.add(box[b - 1]);
      n += count[b - 1];
      if (n == 0 || n == all) continue;
      const float cost = sum.half_area() * static_cast<float>(n) + right[b];
      if (cost < split.cost) split = {axis, b, cost};
    }
  }

  static constexpr float least_width = static_cast<float>(tolerance::no_extent);
  Lanes low_, scale_;
};

class HierarchyBuilder {
 public:
  HierarchyBuilder(const MeshModel& mesh, std::span<std::uint32_t> triangles, std::uint32_t place, int level,
                   const PartRunner& parts)
      : mesh_(mesh), place_(place), runner_(parts) {
    const auto n = static_cast<std::uint32_t>(triangles.size());
    references_.resize(n);
    Range all{0, n};
    for (std::uint32_t i = 0; i < n; ++i) {
      references_[i] = reference(triangles[i]);
      all.centres.add(references_[i].centre(), references_[i].centre());
    }
    build(all, level, tree_);
    for (std::uint32_t i = 0; i < n; ++i) triangles[i] = references_[i].triangle;
  }

  HierarchyTree& tree() { return tree_; }

 private:
  Vec3 in_units(const Vec3& p) const { return (p - mesh_.centre) / mesh_.unit; }

  // Rounded to nearest: splits need no more.
  Reference reference(std::uint32_t triangle) const {
    const auto c = mesh_.corners(triangle);
    const Vec3 lo = in_units(c[0].cwiseMin(c[1]).cwiseMin(c[2])), hi = in_units(c[0].cwiseMax(c[1]).cwiseMax(c[2]));
    Reference r{{}, triangle, {}};
    for (int axis = 0; axis < 3; ++axis)
      r.low[axis] = static_cast<float>(lo[axis]), r.high[axis] = static_cast<float>(hi[axis]);
    return r;
  }

  Content build(const Range& range, int level, HierarchyTree& tree) {
    const auto self = static_cast<std::uint32_t>(tree.nodes.size());
    tree.nodes.emplace_back();
    tree.depth = std::max(tree.depth, level);
    std::array<Content, mesh_lanes> held;
    MeshNode node{};
    node.bottom = range.size() <= mesh_lanes;
    if (node.bottom) {
      node.lanes = range.size();
      add_triangles(range, node, held, tree);
    } else {
      std::array<Range, mesh_lanes> part;
      node.lanes = split(range, level, part);
      build_children(part, level + 1, node, held, tree);
      add_slabs(node, held, tree);
    }
    for (std::uint32_t k = 0; k < mesh_lanes; ++k)
      for (int axis = 0; axis < 3; ++axis) store_box(held[k], axis, node.mid[axis][k], node.half[axis][k]);
    Content all = held[0];
    for (std::uint32_t k = 1; k < node.lanes; ++k) all.add(held[k]);
    for (int axis = 0; axis < 3; ++axis) store_box(all, axis, node.box_mid[axis], node.box_half[axis]);
    node.reach = *std::max_element(node.box_half, node.box_half + 3);
    tree.nodes[self] = node;
    return all;
  }

  // The largest part is split until there are eight, or all fit in a bottom node.
  std::uint32_t split(const Range& range, int level, std::array<Range, mesh_lanes>& part) {
    part[0] = range;
    std::uint32_t lanes = 1;
    while (lanes < mesh_lanes) {
      std::uint32_t largest = 0;
      for (std::uint32_t k = 1; k < lanes; ++k)
        if (part[k].size() > part[largest].size()) largest = k;
      if (part[largest].size() <= mesh_lanes) break;
      const Range whole = part[largest];
      halve(whole, level, part[largest], part[lanes++]);
    }
    return lanes;
  }

  void build_children(const std::array<Range, mesh_lanes>& part, int level, MeshNode& node,
                      std::array<Content, mesh_lanes>& held, HierarchyTree& tree) {
    const auto size = [&](std::uint32_t k) { return part[k].size(); };
    std::uint32_t all = 0;
    for (std::uint32_t k = 0; k < node.lanes; ++k) all += size(k);
    if (!runner_ || all <= shared_above) {
      for (std::uint32_t k = 0; k < node.lanes; ++k) {
        node.child[k] = static_cast<std::uint32_t>(tree.nodes.size());
        held[k] = build(part[k], level, tree);
      }
      return;
    }
    std::array<HierarchyTree, mesh_lanes> subtree;
    runner_(node.lanes, [&](std::size_t k) { held[k] = build(part[k], level, subtree[k]); });
    for (std::uint32_t k = 0; k < node.lanes; ++k) node.child[k] = tree.append(subtree[k]);
  }

  void add_triangles(const Range& range, MeshNode& node, std::array<Content, mesh_lanes>& held, HierarchyTree& tree) {
    node.block = static_cast<std::uint32_t>(tree.blocks.size());
    TriangleBlock& block = tree.blocks.emplace_back();
    for (std::uint32_t k = 0; k < mesh_lanes; ++k) {
      const std::uint32_t at = range.begin + std::min(k, node.lanes - 1);  // lanes not in use repeat the last
      std::array<Vec3, 3> c = mesh_.corners(references_[at].triangle);
      for (Vec3& p : c) p = in_units(p);
      for (std::size_t i = 0; i < 3; ++i)
        for (int axis = 0; axis < 3; ++axis) block.corner[i][axis][k] = static_cast<float>(c[i][axis]);
      if (k >= node.lanes) continue;
      node.child[k] = place_ + at;
      node.count[k] = 1;
      Content& content = held[k];
      content.low = c[0].cwiseMin(c[1]).cwiseMin(c[2]);
      content.high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
      content.corners = 3;
      content.mean = (c[0] + c[1] + c[2]) / 3;
      for (const Vec3& p : c) {
        const Vec3 off = p - content.mean;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j <= i; ++j) content.spread(i, j) += off[i] * off[j];
      }
    }
  }

  void add_slabs(MeshNode& node, const std::array<Content, mesh_lanes>& held, HierarchyTree& tree) {
    node.block = static_cast<std::uint32_t>(tree.slabs.size());
    ChildSlabs& slabs = tree.slabs.emplace_back();
    for (std::uint32_t k = 0; k < node.lanes; ++k) {
      Eigen::SelfAdjointEigenSolver<Mat3> axes;
      axes.computeDirect(held[k].spread);
      Vec3 thin = axes.eigenvectors().col(0);
      if (!(std::abs(thin.norm() - 1) < tolerance::no_direction)) thin = Vec3::UnitX();
      for (int axis = 0; axis < 3; ++axis) slabs.normal[axis][k] = static_cast<float>(thin[axis]);
      // The blocks of a subtree lie behind one another.
      const std::uint32_t next = k + 1 < node.lanes ? first_block(node.child[k + 1], tree) : end_of(tree);
      const auto [low, high] = heights(tree, first_block(node.child[k], tree), next, slabs, k);
      const float pad = static_cast<float>(tolerance::height_of_floats);
      slabs.mid[k] = (low + high) / 2;
      slabs.half[k] = std::max(high - slabs.mid[k], slabs.mid[k] - low) + pad;
    }
  }

  static std::uint32_t end_of(const HierarchyTree& tree) { return static_cast<std::uint32_t>(tree.blocks.size()); }
  static std::uint32_t first_block(std::uint32_t node, const HierarchyTree& tree) {
    while (!tree.nodes[node].bottom) node = tree.nodes[node].child[0];
    return tree.nodes[node].block;
  }

  // The least and most of the corners of some blocks along a direction.
  static std::pair<float, float> heights(const HierarchyTree& tree, std::uint32_t from, std::uint32_t to, const ChildSlabs& slabs,
                                         std::uint32_t k) {
    FlatBox box;
    const Lanes x = all_four(slabs.normal[0][k]), y = all_four(slabs.normal[1][k]), z = all_four(slabs.normal[2][k]);
    for (std::uint32_t b = from; b < to; ++b)
      for (const auto& corner : tree.blocks[b].corner)
        for (std::size_t lane = 0; lane < mesh_lanes; lane += 4) {
          const Lanes at = x * load_four(corner[0] + lane) + y * load_four(corner[1] + lane) + z * load_four(corner[2] + lane);
          box.add(at, at);
        }
    return {std::min({box.low[0], box.low[1], box.low[2], box.low[3]}),
            std::max({box.high[0], box.high[1], box.high[2], box.high[3]})};
  }

  // The middle and half of an interval, rounded outward; nothing has half = -1e30.
  void store_box(const Content& c, int axis, float& mid, float& half) const {
    mid = 0, half = -1e30f;
    if (!(c.low[axis] <= c.high[axis])) return;
    mid = static_cast<float>((c.low[axis] + c.high[axis]) / 2);
    // In units about the centre: the difference was rounded there.
    const double pad = tolerance::outward * (1 + std::abs(mesh_.centre[axis]) / mesh_.unit);
    const double exact = std::max(c.high[axis] - mid, mid - c.low[axis]) + pad;
    half = std::nextafter(static_cast<float>(exact), std::numeric_limits<float>::infinity());
  }

  // By the surface area heuristic; by the median where that brings nothing.
  void halve(const Range& r, int level, Range& left, Range& right) {
    Reference* const from = references_.data() + r.begin;
    Reference* const to = references_.data() + r.end;
    Reference* middle = from + r.size() / 2;
    const Binning binning(r.centres);
    const Split best = level < last_binned_level ? binning.best(from, to) : Split{};
    if (best.axis >= 0) {
      middle = std::partition(from, to, [&](const Reference& x) {
        return binning.bins_of(x)[static_cast<std::size_t>(best.axis)] < best.bin;
      });
    } else {
      halve_by_median(r, from, middle, to);
    }
    const auto place = static_cast<std::uint32_t>(middle - references_.data());
    left = {r.begin, place};
    right = {place, r.end};
    for (const Reference* x = from; x != middle; ++x) left.centres.add(x->centre(), x->centre());
    for (const Reference* x = middle; x != to; ++x) right.centres.add(x->centre(), x->centre());
  }

  static void halve_by_median(const Range& r, Reference* from, Reference* middle, Reference* to) {
    const Lanes width = r.centres.high - r.centres.low;
    const int axis = width[0] >= width[1] && width[0] >= width[2] ? 0 : width[1] >= width[2] ? 1 : 2;
    std::nth_element(from, middle, to, [&](const Reference& a, const Reference& b) {
      const float p = a.low[axis] + a.high[axis], q = b.low[axis] + b.high[axis];
      return p != q ? p < q : a.triangle < b.triangle;
    });
  }

  const MeshModel& mesh_;
  const std::uint32_t place_;  // of the first triangle in the mesh's order
  const PartRunner& runner_;
  std::vector<Reference> references_;
  HierarchyTree tree_;
};

}  // namespace

std::uint32_t HierarchyTree::append(const HierarchyTree& other) {
  const auto first = static_cast<std::uint32_t>(nodes.size()), block = static_cast<std::uint32_t>(blocks.size()),
             slab = static_cast<std::uint32_t>(slabs.size());
  for (MeshNode node : other.nodes) {
    node.block += node.bottom ? block : slab;
    for (std::uint32_t k = 0; k < node.lanes && !node.bottom; ++k) node.child[k] += first;
    nodes.push_back(node);
  }
  blocks.insert(blocks.end(), other.blocks.begin(), other.blocks.end());
  slabs.insert(slabs.end(), other.slabs.begin(), other.slabs.end());
  depth = std::max(depth, other.depth);
  return first;
}

HierarchyTree build_subtree(const MeshModel& mesh, std::span<std::uint32_t> triangles, std::uint32_t place, int level,
                            const PartRunner& parts) {
  return std::move(HierarchyBuilder(mesh, triangles, place, level, parts).tree());
}

void build_hierarchy(MeshModel& mesh, const PartRunner& parts) {
  mesh.order.resize(mesh.triangles.size());
  std::iota(mesh.order.begin(), mesh.order.end(), 0u);
  const HierarchyTree tree = build_subtree(mesh, mesh.order, 0, 1, parts);
  // Of the size that is needed: they stay as long as the mesh does.
  mesh.nodes.assign(tree.nodes.begin(), tree.nodes.end());
  mesh.blocks.assign(tree.blocks.begin(), tree.blocks.end());
  mesh.slabs.assign(tree.slabs.begin(), tree.slabs.end());
  mesh.depth = tree.depth;
}

double farthest_along(const MeshModel& mesh, const Vec3& direction) {
  double most = -infinity;
  const Vec3 extent = direction.cwiseAbs();
  const double base = direction.dot(mesh.centre);
  // Subtrees by how far their boxes reach, the farthest on top.
  struct Reach {
    double bound;
    std::uint32_t node;
  };
  std::vector<Reach> stack{{infinity, 0}};
  while (!stack.empty()) {
    const Reach at = stack.back();
    stack.pop_back();
    if (!(at.bound > most)) continue;
    const MeshNode& node = mesh.nodes[at.node];
    const std::size_t first = stack.size();
    for (std::uint32_t k = 0; k < node.lanes; ++k) {
      const Vec3 mid(node.mid[0][k], node.mid[1][k], node.mid[2][k]), half(node.half[0][k], node.half[1][k], node.half[2][k]);
      const double bound = base + mesh.unit * (direction.dot(mid) + extent.dot(half));
      if (!(bound > most)) continue;
      if (!node.bottom)
        stack.push_back({bound, node.child[k]});
      else
        for (const Vec3& corner : mesh.corners(mesh.order[node.child[k]])) most = std::max(most, direction.dot(corner));
    }
    std::sort(stack.begin() + static_cast<std::ptrdiff_t>(first), stack.end(),
              [](const Reach& x, const Reach& y) { return x.bound < y.bound; });
  }
  return most;
}

}  // namespace tandem
