// Fills the nodes of a mesh's hierarchy with boxes, slabs and corners, from the leaves up.
#include "shapes/mesh_hierarchy.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "lanes/four_floats.h"
#include "shapes/mesh_splits.h"
#include "shapes/run_parts.h"
#include "tolerances.h"

namespace tandem {
namespace {
using Lanes = FourFloats;

constexpr std::size_t corners_per_chunk = 8192;

// The content of a subtree: its box, and the covariance of its corners.
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

// The next float above a finite one.
float next_up(float x) {
  if (!(x > 0)) return std::nextafter(x, std::numeric_limits<float>::infinity());
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) + 1);
}

// Stores the centre and half size of an interval in units of the mesh, rounded outward; an empty one has half = -1e30.
void store_interval(const MeshModel& mesh, double scale, int axis, double low, double high, float& mid, float& half) {
  mid = 0, half = -1e30f;
  if (!(low <= high)) return;
  mid = static_cast<float>((low + high) / 2);
  // In units about the centre, where the difference was rounded.
  const double pad = tolerance::outward * (1 + std::abs(mesh.centre[axis]) * scale);
  half = next_up(static_cast<float>(std::max(high - mid, mid - low) + pad));
}

class HierarchyFiller {
 public:
  HierarchyFiller(const MeshModel& mesh, std::span<const FourFloats> corners, const SplitTree& splits,
                  std::span<const std::uint32_t> triangles, std::uint32_t place, const PartRunner& parts,
                  BuildMeter& meter)
      : mesh_(mesh),
        corners_(corners),
        splits_(splits.nodes),
        triangles_(triangles),
        place_(place),
        runner_(parts),
        meter_(meter),
        scale_(1 / mesh.unit) {
    const SplitNode& root = splits_.front();
    tree_.nodes.resize(root.nodes);
    tree_.blocks.resize(root.bottoms);
    tree_.boxes.resize(root.nodes - root.bottoms);
    tree_.slabs.resize(root.nodes - root.bottoms);
    tree_.depth = splits.depth;
    fill(0, 0);
    if (root.end - root.begin <= shared_above) meter.spend(root.end - root.begin);
  }

  HierarchyTree& tree() { return tree_; }

 private:
  // Fills the subtree of a node that is preceded by so many bottom nodes.
  Content fill(std::uint32_t self, std::uint32_t bottoms) {
    const SplitNode& split = splits_[self];
    std::array<Content, mesh_lanes> held;
    MeshNode node{};
    if (split.bottom()) {
      node.block = bottoms;
      node.set(true, split.lanes, place_ + split.begin);
      add_triangles(split, tree_.blocks[node.block], held);
    } else {
      node.block = self - bottoms;
      node.set(false, split.lanes, 0);
      fill_children(self, bottoms, node, held);
    }
    Content all = held[0];
    for (std::uint32_t k = 1; k < split.lanes; ++k) all.add(held[k]);
    for (int axis = 0; axis < 3; ++axis) store_box(all, axis, node.box_mid[axis], node.box_half[axis]);
    tree_.nodes[self] = node;
    return all;
  }

  void fill_children(std::uint32_t self, std::uint32_t bottoms, const MeshNode& node,
                     std::array<Content, mesh_lanes>& held) {
    const std::uint32_t lanes = node.lanes();
    ChildBoxes& boxes = tree_.boxes[node.block];
    boxes = {};
    std::array<std::uint32_t, mesh_lanes + 1> before{bottoms};
    for (std::uint32_t k = 0, at = self + 1; k < lanes; at += splits_[at].nodes, ++k)
      boxes.child[k] = at, before[k + 1] = before[k] + splits_[at].bottoms;
    ChildSlabs& slabs = tree_.slabs[node.block];
    slabs = {};
    const auto fill_child = [&](std::size_t k) {
      const SplitNode& child = splits_[boxes.child[k]];
      held[k] = fill(boxes.child[k], before[k]);
      add_slab(held[k], before[k], before[k + 1], slabs, k);
      return child.end - child.begin;
    };
    if (splits_[self].end - splits_[self].begin <= shared_above)
      for (std::uint32_t k = 0; k < lanes; ++k) fill_child(k);
    else
      run_parts(runner_, lanes, [&](std::size_t k) {
        if (const std::uint32_t size = fill_child(k); size <= shared_above) meter_.spend(size);
      });
    for (std::uint32_t k = 0; k < mesh_lanes; ++k)
      for (int axis = 0; axis < 3; ++axis) store_box(held[k], axis, boxes.mid[axis][k], boxes.half[axis][k]);
  }

  void add_triangles(const SplitNode& split, TriangleBlock& block, std::array<Content, mesh_lanes>& held) {
    for (std::uint32_t k = 0; k < mesh_lanes; ++k) {
      const std::uint32_t at = split.begin + std::min(k, split.lanes - 1);  // unused lanes repeat the last one
      const auto& t = mesh_.triangles[triangles_[at]];
      for (std::size_t i = 0; i < 3; ++i)
        for (int axis = 0; axis < 3; ++axis) block.corner[i][axis][k] = corners_[t[i]][axis];
      if (k >= split.lanes) continue;
      std::array<Vec3, 3> c;
      for (std::size_t i = 0; i < 3; ++i) c[i] = (mesh_.vertices[t[i]] - mesh_.centre) * scale_;
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

  // Adds the slab of a child whose triangles are in these blocks.
  void add_slab(const Content& held, std::uint32_t from, std::uint32_t to, ChildSlabs& slabs, std::size_t k) const {
    Eigen::SelfAdjointEigenSolver<Mat3> axes;
    axes.computeDirect(held.spread);
    Vec3 thin = axes.eigenvectors().col(0);
    if (!(std::abs(thin.norm() - 1) < tolerance::no_direction)) thin = Vec3::UnitX();
    for (int axis = 0; axis < 3; ++axis) slabs.normal[axis][k] = static_cast<float>(thin[axis]);
    const auto [low, high] = heights(from, to, slabs, k);
    const float pad = static_cast<float>(tolerance::height_of_floats);
    slabs.mid[k] = (low + high) / 2;
    slabs.half[k] = std::max(high - slabs.mid[k], slabs.mid[k] - low) + pad;
  }

  // The minimum and maximum of the corners of some blocks along a direction.
  std::pair<float, float> heights(std::uint32_t from, std::uint32_t to, const ChildSlabs& slabs, std::size_t k) const {
    Lanes least = all_four(std::numeric_limits<float>::infinity()), most = -least;
    const Lanes x = all_four(slabs.normal[0][k]), y = all_four(slabs.normal[1][k]), z = all_four(slabs.normal[2][k]);
    for (std::uint32_t b = from; b < to; ++b)
      for (const auto& corner : tree_.blocks[b].corner)
        for (std::size_t lane = 0; lane < mesh_lanes; lane += 4) {
          const Lanes at =
              x * load_four(corner[0] + lane) + y * load_four(corner[1] + lane) + z * load_four(corner[2] + lane);
          least = min_of(least, at), most = max_of(most, at);
        }
    return {std::min({least[0], least[1], least[2], least[3]}), std::max({most[0], most[1], most[2], most[3]})};
  }

  void store_box(const Content& c, int axis, float& mid, float& half) const {
    store_interval(mesh_, scale_, axis, c.low[axis], c.high[axis], mid, half);
  }

  const MeshModel& mesh_;
  const std::span<const FourFloats> corners_;
  const std::span<const SplitNode> splits_;
  const std::span<const std::uint32_t> triangles_;  // in the order of the leaves
  const std::uint32_t place_;                       // position of the first of them in the mesh's order
  const PartRunner& runner_;
  BuildMeter& meter_;
  const double scale_;
  HierarchyTree tree_;
};

}  // namespace

std::uint32_t HierarchyTree::append(const HierarchyTree& other) {
  const auto first = static_cast<std::uint32_t>(nodes.size()), block = static_cast<std::uint32_t>(blocks.size()),
             slab = static_cast<std::uint32_t>(slabs.size());
  for (MeshNode node : other.nodes) {
    if (!node.bottom()) {
      ChildBoxes& own = boxes.emplace_back(other.boxes[node.block]);
      for (std::uint32_t k = 0; k < node.lanes(); ++k) own.child[k] += first;
    }
    node.block += node.bottom() ? block : slab;
    nodes.push_back(node);
  }
  blocks.insert(blocks.end(), other.blocks.begin(), other.blocks.end());
  slabs.insert(slabs.end(), other.slabs.begin(), other.slabs.end());
  depth = std::max(depth, other.depth);
  return first;
}

void box_of_triangle(const MeshModel& mesh, std::uint32_t triangle, float (&mid)[3], float (&half)[3]) {
  const double scale = 1 / mesh.unit;
  auto corners = mesh.corners(triangle);
  for (Vec3& corner : corners) corner = (corner - mesh.centre) * scale;
  const Vec3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]),
             high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  for (int axis = 0; axis < 3; ++axis) store_interval(mesh, scale, axis, low[axis], high[axis], mid[axis], half[axis]);
}

namespace detail {

// Corners in floats, which are at most 1/2, have errors of at most a quarter of epsilon, and so have centres of boxes.
float MeshModel::corner_pad() const {
  return static_cast<float>(tolerance::epsilon_of_floats / 2 +
                            tolerance::outward * (1 + centre.cwiseAbs().maxCoeff() / unit));
}

void MeshModel::boxes_of_triangles(const MeshNode& bottom, LaneBoxes& out) const {
  const TriangleBlock& block = blocks[bottom.block];
  const Lanes pad = all_four(corner_pad());
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t l = 0; l < mesh_lanes; l += 4) {
      const Lanes p = load_four(block.corner[0][axis] + l), q = load_four(block.corner[1][axis] + l),
                  r = load_four(block.corner[2][axis] + l);
      const Lanes low = min_of(p, min_of(q, r)), high = max_of(p, max_of(q, r)), mid = (low + high) * all_four(0.5f);
      store_four(mid, out.mid[axis] + l);
      store_four(max_of(high - mid, mid - low) + pad, out.half[axis] + l);
    }
}

}  // namespace detail

CornersInUnits corners_in_units(const MeshModel& mesh, const PartRunner& parts) {
  CornersInUnits corners;
  place_corners(mesh, mesh.vertices, parts, corners);
  return corners;
}

void place_corners(const MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts,
                   CornersInUnits& corners) {
  const std::size_t count = vertices.size();
  const double scale = 1 / mesh.unit;
  corners.resize(count);
  run_chunks(parts, count, corners_per_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3 p = (vertices[v] - mesh.centre) * scale;
      corners[v] = Lanes{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0};
    }
  });
}

HierarchyTree build_subtree(const MeshModel& mesh, std::span<const FourFloats> corners,
                            std::span<std::uint32_t> triangles, std::uint32_t place, int level, const PartRunner& parts,
                            BuildMeter& meter) {
  const SplitTree splits = split_triangles(mesh, corners, triangles, level, parts, meter);
  return std::move(HierarchyFiller(mesh, corners, splits, triangles, place, parts, meter).tree());
}

void build_hierarchy(MeshModel& mesh, const PartRunner& parts, BuildMeter& meter) {
  mesh.order.resize(mesh.triangles.size());
  run_chunks(parts, mesh.order.size(), elements_per_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::iota(mesh.order.data() + begin, mesh.order.data() + end, static_cast<std::uint32_t>(begin));
  });
  HierarchyTree tree = build_subtree(mesh, corners_in_units(mesh, parts), mesh.order, 0, 1, parts, meter);
  mesh.nodes = std::move(tree.nodes);
  mesh.blocks = std::move(tree.blocks);
  mesh.boxes = std::move(tree.boxes);
  mesh.slabs = std::move(tree.slabs);
  mesh.depth = tree.depth;
}

void build_hierarchy(MeshModel& mesh, const PartRunner& parts) {
  const BuildOptions options;
  BuildMeter meter(options, hierarchy_work(mesh.triangles.size()));
  build_hierarchy(mesh, parts, meter);
}

double farthest_along(const MeshModel& mesh, const Vec3& direction) {
  double most = -infinity;
  const Vec3 extent = direction.cwiseAbs();
  const double base = direction.dot(mesh.centre);
  // Subtrees by the distance their boxes reach, the farthest on top.
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
    if (node.bottom()) {
      for (std::uint32_t k = 0; k < node.lanes(); ++k)
        for (const Vec3& corner : mesh.corners(mesh.triangle_of(node, k))) most = std::max(most, direction.dot(corner));
      continue;
    }
    const std::size_t first = stack.size();
    const ChildBoxes& boxes = mesh.boxes_of(node);
    for (std::uint32_t k = 0; k < node.lanes(); ++k) {
      const Vec3 mid(boxes.mid[0][k], boxes.mid[1][k], boxes.mid[2][k]),
          half(boxes.half[0][k], boxes.half[1][k], boxes.half[2][k]);
      const double bound = base + mesh.unit * (direction.dot(mid) + extent.dot(half));
      if (bound > most) stack.push_back({bound, boxes.child[k]});
    }
    std::sort(stack.begin() + static_cast<std::ptrdiff_t>(first), stack.end(),
              [](const Reach& x, const Reach& y) { return x.bound < y.bound; });
  }
  return most;
}

}  // namespace tandem
