#include "shapes/mesh_refit.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <utility>

#include "shapes/run_parts.h"
#include "tolerances.h"

namespace tandem {
namespace {

using Lanes = FourFloats;

// A subtree whose boxes have grown so much costs a query about as much more; building it anew costs some thirty refits.
constexpr double worn_from = 1.5;
// Subtrees that threads share: enough of them for any number of cores, none so small that its boxes hardly matter.
constexpr std::size_t most_subtrees = 256;
constexpr std::uint32_t least_subtree = 1024;  // triangles

struct LaneBox {
  Lanes low = all_four(std::numeric_limits<float>::infinity()), high = -low;
  void add(Lanes l, Lanes h) { low = min_of(low, l), high = max_of(high, h); }
};

// Rows of four to columns.
void transpose(const Lanes* rows, Lanes* columns) {
  const Lanes a = __builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5);
  const Lanes b = __builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7);
  const Lanes c = __builtin_shufflevector(rows[2], rows[3], 0, 4, 1, 5);
  const Lanes d = __builtin_shufflevector(rows[2], rows[3], 2, 6, 3, 7);
  columns[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  columns[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  columns[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
}

// Eight of x, y, z, ... as three rows of eight.
void store_rows(const Lanes* eight, float (*rows)[mesh_lanes]) {
  for (std::size_t l = 0; l < mesh_lanes; l += 4) {
    Lanes column[3];
    transpose(eight + l, column);
    for (int axis = 0; axis < 3; ++axis) std::memcpy(rows[axis] + l, &column[axis], sizeof(Lanes));
  }
}

Lanes cross(Lanes u, Lanes v) {
  const Lanes u_next = __builtin_shufflevector(u, u, 1, 2, 0, 3), v_next = __builtin_shufflevector(v, v, 1, 2, 0, 3);
  const Lanes w = u * v_next - u_next * v;
  return __builtin_shufflevector(w, w, 1, 2, 0, 3);
}

// Half the areas of the boxes of a node's first lanes, summed.
double half_areas(const LaneBoxes& boxes, std::uint32_t lanes) {
  double sum = 0;
  for (std::size_t l = 0; l < mesh_lanes; l += 4) {
    Lanes half[3];
    for (int axis = 0; axis < 3; ++axis) half[axis] = max_of(load_four(boxes.half[axis] + l), all_four(0));
    const Lanes area = half[0] * half[1] + half[1] * half[2] + half[2] * half[0];
    for (std::size_t k = 0; k < 4 && l + k < lanes; ++k) sum += static_cast<double>(area[k]);
  }
  return sum;
}

double half_areas(const MeshModel& mesh, const MeshNode& node) {
  LaneBoxes room;
  return half_areas(mesh.lane_boxes(node, room), node.lanes());
}

}  // namespace

MeshRefit::MeshRefit(const MeshModel& mesh) {
  cut(mesh);
  for (Subtree& s : subtrees_) {
    for (std::uint32_t n = s.node; n < s.end_node; ++n)
      (mesh.nodes[n].bottom() ? s.areas.leaves : s.areas.inner) += half_areas(mesh, mesh.nodes[n]);
    s.built = s.areas.ratio();
  }
  for (const std::uint32_t n : top_) top_areas_.inner += half_areas(mesh, mesh.nodes[n]);
  top_built_ = sum_of_all().ratio();
}

// Subtrees of no more triangles than threads need, and what is above them.
void MeshRefit::cut(const MeshModel& mesh) {
  const auto size = static_cast<std::uint32_t>(mesh.nodes.size());
  std::vector<Subtree> all(size);
  for (std::uint32_t n = size; n-- > 0;) {
    const MeshNode& node = mesh.nodes[n];
    all[n] = {n, n + 1, node.first(), node.first() + node.lanes(), 0, 0, {}};
    if (node.bottom()) continue;
    const std::span child = std::span(mesh.boxes_of(node).child).first(node.lanes());
    // Nodes lie in the order of the lanes; triangles need not.
    all[n] = {n, all[child.back()].end_node, all[child[0]].begin, all[child[0]].end, 0, 0, {}};
    for (const std::uint32_t c : child) {
      all[n].begin = std::min(all[n].begin, all[c].begin);
      all[n].end = std::max(all[n].end, all[c].end);
    }
  }
  const auto limit = std::max(least_subtree, static_cast<std::uint32_t>(mesh.order.size() / most_subtrees));
  subtrees_.clear();
  top_.clear();
  std::vector<std::pair<std::uint32_t, int>> stack{{0, 1}};
  while (!stack.empty()) {
    const auto [n, level] = stack.back();
    stack.pop_back();
    all[n].level = level;
    if (mesh.nodes[n].bottom() || all[n].end - all[n].begin <= limit) {
      subtrees_.push_back(all[n]);
      continue;
    }
    top_.push_back(n);
    const ChildBoxes& boxes = mesh.boxes_of(mesh.nodes[n]);
    for (std::uint32_t k = mesh.nodes[n].lanes(); k-- > 0;) stack.emplace_back(boxes.child[k], level + 1);
  }
}

void MeshRefit::refit_bottom(MeshModel& mesh, MeshNode& node, Lanes& normal, Areas& areas) const {
  Lanes corner[3][mesh_lanes];
  LaneBox all;
  Lanes leaves = all_four(0);  // half areas
  normal = all_four(0);
  for (std::uint32_t k = 0; k < mesh_lanes; ++k) {
    if (k >= node.lanes()) {  // repeats the last
      for (auto& c : corner) c[k] = c[k - 1];
      continue;
    }
    const auto& t = mesh.triangles[mesh.triangle_of(node, k)];
    const Lanes p = corners_[t[0]], q = corners_[t[1]], r = corners_[t[2]];
    corner[0][k] = p, corner[1][k] = q, corner[2][k] = r;
    const Lanes low = min_of(p, min_of(q, r)), high = max_of(p, max_of(q, r));
    all.add(low, high);
    const Lanes half = (high - low) * all_four(0.5f) + all_four(pad_);
    leaves += half * __builtin_shufflevector(half, half, 1, 2, 0, 3);
    normal += cross(q - p, r - p);
  }
  TriangleBlock& block = mesh.blocks[node.block];
  for (std::size_t c = 0; c < 3; ++c) store_rows(corner[c], block.corner[c]);
  const Lanes middle = (all.low + all.high) * all_four(0.5f);
  const Lanes reach = max_of(all.high - middle, middle - all.low) + all_four(pad_);
  for (int axis = 0; axis < 3; ++axis) node.box_mid[axis] = middle[axis], node.box_half[axis] = reach[axis];
  areas.leaves += static_cast<double>(leaves[0]) + static_cast<double>(leaves[1]) + static_cast<double>(leaves[2]);
}

void MeshRefit::refit_inner(MeshModel& mesh, MeshNode& node, Lanes& normal, Areas& areas) const {
  ChildBoxes& boxes = mesh.boxes[node.block];
  ChildSlabs& slabs = mesh.slabs[node.block];
  normal = all_four(0);
  double low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) low[axis] = infinity, high[axis] = -infinity;
  for (std::uint32_t k = 0; k < node.lanes(); ++k) {
    const MeshNode& child = mesh.nodes[boxes.child[k]];
    for (int axis = 0; axis < 3; ++axis) {
      boxes.mid[axis][k] = child.box_mid[axis], boxes.half[axis][k] = child.box_half[axis];
      const double mid = static_cast<double>(child.box_mid[axis]), half = static_cast<double>(child.box_half[axis]);
      low[axis] = std::min(low[axis], mid - half), high[axis] = std::max(high[axis], mid + half);
    }
    normal += normals_[boxes.child[k]];
    refit_slab(mesh, boxes.child[k], slabs, k);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto mid = static_cast<float>((low[axis] + high[axis]) / 2);
    const double exact = std::max(high[axis] - static_cast<double>(mid), static_cast<double>(mid) - low[axis]);
    node.box_mid[axis] = mid;
    node.box_half[axis] = std::nextafter(static_cast<float>(exact), std::numeric_limits<float>::infinity());
  }
  areas.inner += half_areas(boxes, node.lanes());
}

// Between two planes across the sum of the triangles' area vectors: what a surface that bends little is thin along.
void MeshRefit::refit_slab(const MeshModel& mesh, std::uint32_t child, ChildSlabs& slabs, std::size_t lane) const {
  const Lanes area = normals_[child];
  const float length = std::sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
  Lanes n = area / all_four(length);
  if (!(std::abs(static_cast<double>(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 1) < tolerance::no_direction))
    n = Lanes{1, 0, 0, 0};
  const Lanes x = all_four(n[0]), y = all_four(n[1]), z = all_four(n[2]);
  LaneBox heights;
  const MeshNode& below = mesh.nodes[child];
  if (below.bottom()) {
    for (const auto& corner : mesh.blocks[below.block].corner)
      for (std::size_t l = 0; l < mesh_lanes; l += 4) {
        const Lanes at = x * load_four(corner[0] + l) + y * load_four(corner[1] + l) + z * load_four(corner[2] + l);
        heights.add(at, at);
      }
  } else {
    const ChildBoxes& boxes = mesh.boxes_of(below);
    for (std::size_t l = 0; l < mesh_lanes; l += 4) {
      const auto sum = [l](Lanes u, Lanes v, Lanes w, const float(&rows)[3][mesh_lanes]) {
        return u * load_four(rows[0] + l) + v * load_four(rows[1] + l) + w * load_four(rows[2] + l);
      };
      const Lanes at = sum(x, y, z, boxes.mid), reach = sum(absolute(x), absolute(y), absolute(z), boxes.half);
      heights.add(at - reach, at + reach);
    }
  }
  const float low = std::min({heights.low[0], heights.low[1], heights.low[2], heights.low[3]});
  const float high = std::max({heights.high[0], heights.high[1], heights.high[2], heights.high[3]});
  for (int axis = 0; axis < 3; ++axis) slabs.normal[axis][lane] = n[axis];
  slabs.mid[lane] = (low + high) / 2;
  // Twice: of boxes the height of the middle and the reach are off by as much each.
  slabs.half[lane] =
      std::max(high - slabs.mid[lane], slabs.mid[lane] - low) + static_cast<float>(2 * tolerance::height_of_floats);
}

void MeshRefit::refit_node(MeshModel& mesh, std::uint32_t n, Areas& areas) {
  MeshNode& node = mesh.nodes[n];
  if (node.bottom())
    refit_bottom(mesh, node, normals_[n], areas);
  else
    refit_inner(mesh, node, normals_[n], areas);
}

MeshRefit::Areas MeshRefit::sum_of_all() const {
  Areas all = top_areas_;
  for (const Subtree& s : subtrees_) all.leaves += s.areas.leaves;
  return all;
}

// How much more than when it was built.
double MeshRefit::wear(double ratio, double& built) const {
  built = std::min(built, ratio);
  return built > 0 ? ratio / built : 1;
}

MeshRefit::Report MeshRefit::refit(MeshModel& mesh, const PartRunner& parts) {
  place_corners(mesh, parts, corners_);
  pad_ = mesh.corner_pad();
  normals_.resize(mesh.nodes.size());
  run_parts(parts, subtrees_.size(), [&](std::size_t k) {
    Subtree& s = subtrees_[k];
    s.areas = {};
    for (std::uint32_t n = s.end_node; n-- > s.node;) refit_node(mesh, n, s.areas);  // children first
  });
  top_areas_ = {};
  for (auto n = top_.rbegin(); n != top_.rend(); ++n) refit_node(mesh, *n, top_areas_);

  Report report;
  report.worn = wear(sum_of_all().ratio(), top_built_);
  std::vector<std::uint8_t> worn(subtrees_.size(), report.worn > worn_from ? 1 : 0);
  const bool all = report.worn > worn_from;
  for (std::size_t k = 0; k < subtrees_.size(); ++k) {
    const double its = wear(subtrees_[k].areas.ratio(), subtrees_[k].built);
    if (its > worn_from) worn[k] = 1;
    if (worn[k] != 0) report.rebuilt += subtrees_[k].end - subtrees_[k].begin;
    report.worn = std::max(report.worn, its);
  }
  if (all) {
    build_hierarchy(mesh, parts);
    *this = MeshRefit(mesh);
  } else if (report.rebuilt != 0) {
    rebuild(mesh, worn, parts);
  }
  return report;
}

// Builds subtrees anew and puts the hierarchy together of these, of those that stay, and of what is above them all.
void MeshRefit::rebuild(MeshModel& mesh, const std::vector<std::uint8_t>& worn, const PartRunner& parts) {
  std::vector<HierarchyTree> fresh(subtrees_.size());
  const BuildOptions no_limit;
  BuildMeter meter(no_limit, hierarchy_work(mesh.triangles.size()));
  run_parts(parts, subtrees_.size(), [&](std::size_t k) {
    const Subtree& s = subtrees_[k];
    if (worn[k] == 0) return;
    const std::span<std::uint32_t> triangles = std::span(mesh.order).subspan(s.begin, s.end - s.begin);
    fresh[k] = build_subtree(mesh, corners_, triangles, s.begin, s.level, {}, meter);
  });
  HierarchyTree all;
  all.nodes.reserve(mesh.nodes.size());
  all.blocks.reserve(mesh.blocks.size());
  all.boxes.reserve(mesh.boxes.size());
  all.slabs.reserve(mesh.slabs.size());
  std::size_t subtree = 0;
  const auto keep = [&](const MeshNode& node) {
    MeshNode& kept = all.nodes.emplace_back(node);
    kept.block = static_cast<std::uint32_t>(node.bottom() ? all.blocks.size() : all.slabs.size());
    if (node.bottom()) {
      all.blocks.push_back(mesh.blocks[node.block]);
    } else {
      all.boxes.push_back(mesh.boxes[node.block]);
      all.slabs.push_back(mesh.slabs[node.block]);
    }
    return static_cast<std::uint32_t>(all.nodes.size() - 1);
  };
  // In the order in which `cut` has found them.
  const std::function<std::uint32_t(std::uint32_t)> put = [&](std::uint32_t n) -> std::uint32_t {
    if (subtree < subtrees_.size() && subtrees_[subtree].node == n) {
      const Subtree& s = subtrees_[subtree++];
      if (worn[subtree - 1] != 0) return all.append(fresh[subtree - 1]);
      const auto first = static_cast<std::uint32_t>(all.nodes.size());
      for (std::uint32_t m = s.node; m < s.end_node; ++m) {
        const MeshNode& node = all.nodes[keep(mesh.nodes[m])];
        for (std::uint32_t k = 0; k < node.lanes() && !node.bottom(); ++k)
          all.boxes[node.block].child[k] += first - s.node;
      }
      return first;
    }
    const std::uint32_t self = keep(mesh.nodes[n]);
    const std::uint32_t its = all.nodes[self].block;
    for (std::uint32_t k = 0; k < mesh.nodes[n].lanes(); ++k)
      all.boxes[its].child[k] = put(mesh.boxes_of(mesh.nodes[n]).child[k]);
    return self;
  };
  put(0);
  for (const HierarchyTree& tree : fresh) all.depth = std::max(all.depth, tree.depth);
  mesh.nodes = std::move(all.nodes);
  mesh.blocks = std::move(all.blocks);
  mesh.boxes = std::move(all.boxes);
  mesh.slabs = std::move(all.slabs);
  mesh.depth = std::max(mesh.depth, all.depth);
  measure_anew(mesh, worn);
}

// What stays is measured by what it was when it was built.
void MeshRefit::measure_anew(const MeshModel& mesh, const std::vector<std::uint8_t>& worn) {
  std::vector<double> built;
  for (const Subtree& s : subtrees_) built.push_back(s.built);
  const double top_built = top_built_;
  MeshRefit anew(mesh);
  for (std::size_t k = 0; k < built.size(); ++k)
    if (worn[k] == 0) anew.subtrees_[k].built = built[k];
  anew.top_built_ = top_built;
  *this = std::move(anew);
}

std::size_t MeshRefit::memory() const {
  return subtrees_.capacity() * sizeof(Subtree) + top_.capacity() * sizeof(top_[0]) +
         (corners_.capacity() + normals_.capacity()) * sizeof(Lanes);
}

}  // namespace tandem
