// Refits the hierarchy of a mesh whose vertices have moved, or rebuilds parts of it.
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

// A subtree whose boxes have grown by this factor costs a query about as much more; rebuilding it costs some thirty
// refits.
constexpr double worn_from = 1.5;
// Subtrees distributed over threads: enough of them for any number of cores, none so small that its boxes hardly
// matter.
constexpr std::size_t most_subtrees = 256;
constexpr std::uint32_t least_subtree = 1024;  // triangles

// Transposes columns of x, y, z, 0 to rows.
void transpose(const Lanes* columns, Lanes* rows) {
  const Lanes a = __builtin_shufflevector(columns[0], columns[1], 0, 4, 1, 5);
  const Lanes b = __builtin_shufflevector(columns[0], columns[1], 2, 6, 3, 7);
  const Lanes c = __builtin_shufflevector(columns[2], columns[3], 0, 4, 1, 5);
  const Lanes d = __builtin_shufflevector(columns[2], columns[3], 2, 6, 3, 7);
  rows[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  rows[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  rows[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
}

// Stores eight vectors x, y, z, 0 as three rows of eight.
void store_rows(const Lanes* eight, float (*rows)[mesh_lanes]) {
  for (std::size_t l = 0; l < mesh_lanes; l += 4) {
    Lanes row[3];
    transpose(eight + l, row);
    for (int axis = 0; axis < 3; ++axis) store_four(row[axis], rows[axis] + l);
  }
}

// The four columns of three rows of four; the fourth number of each repeats the third.
std::array<Lanes, 4> columns_of(const Lanes* rows) {
  const Lanes a = __builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5);
  const Lanes b = __builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7);
  return {__builtin_shufflevector(a, rows[2], 0, 1, 4, 4), __builtin_shufflevector(a, rows[2], 2, 3, 5, 5),
          __builtin_shufflevector(b, rows[2], 0, 1, 6, 6), __builtin_shufflevector(b, rows[2], 2, 3, 7, 7)};
}

Lanes sums_of(const Lanes* rows) {
  const auto c = columns_of(rows);
  return (c[0] + c[1]) + (c[2] + c[3]);
}
Lanes least_of_rows(const Lanes* rows) {
  const auto c = columns_of(rows);
  return min_of(min_of(c[0], c[1]), min_of(c[2], c[3]));
}
Lanes most_of_rows(const Lanes* rows) {
  const auto c = columns_of(rows);
  return max_of(max_of(c[0], c[1]), max_of(c[2], c[3]));
}
float least_of(Lanes v) { return std::min(std::min(v[0], v[2]), std::min(v[1], v[3])); }
float most_of(Lanes v) { return std::max(std::max(v[0], v[2]), std::max(v[1], v[3])); }

// The values of the four lanes from l on that are below `lanes`; 0 for the others.
Lanes only_in_use(Lanes v, std::size_t l, std::uint32_t lanes) {
  using Bits = std::int32_t __attribute__((vector_size(16)));
  const auto first = static_cast<std::int32_t>(l), count = static_cast<std::int32_t>(lanes);
  const Bits at{first, first + 1, first + 2, first + 3}, used = at < Bits{count, count, count, count};
  Bits bits;
  std::memcpy(&bits, &v, sizeof bits);
  bits &= used;
  std::memcpy(&v, &bits, sizeof bits);
  return v;
}

// The sum of half the areas of the boxes of a node's first lanes.
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
  leaves_.resize(mesh.blocks.size());
  for (const MeshNode& node : mesh.nodes)
    for (std::uint32_t k = 0; k < mesh_lanes && node.bottom(); ++k)
      leaves_[node.block][k] = mesh.triangles[mesh.triangle_of(node, std::min(k, node.lanes() - 1))];
  for (Subtree& s : subtrees_) {
    for (std::uint32_t n = s.node; n < s.end_node; ++n)
      (mesh.nodes[n].bottom() ? s.sums.leaves : s.sums.inner) += half_areas(mesh, mesh.nodes[n]);
    s.built = s.sums.ratio();
  }
  for (const std::uint32_t n : top_) top_sums_.inner += half_areas(mesh, mesh.nodes[n]);
  top_built_ = sum_of_all().ratio();
}

// Divides the hierarchy into subtrees for threads, and the nodes above them.
void MeshRefit::cut(const MeshModel& mesh) {
  const auto size = static_cast<std::uint32_t>(mesh.nodes.size());
  std::vector<Subtree> all(size);
  for (std::uint32_t n = size; n-- > 0;) {
    const MeshNode& node = mesh.nodes[n];
    all[n] = {n, n + 1, node.first(), node.first() + node.lanes(), 0, 0, {}, {}};
    if (node.bottom()) continue;
    const std::span child = std::span(mesh.boxes_of(node).child).first(node.lanes());
    // Nodes are in the order of the lanes; triangles need not be.
    all[n] = {n, all[child.back()].end_node, all[child[0]].begin, all[child[0]].end, 0, 0, {}, {}};
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

namespace {

// The slab's direction: the sum of the triangles' area vectors, along which a surface that bends little is thin.
Lanes direction_of(Lanes area) {
  const Lanes squares = area * area;
  const float length = std::sqrt(squares[0] + squares[1] + squares[2]);
  const Lanes n = area / all_four(length), square = n * n;
  if (!(std::abs(static_cast<double>(square[0] + square[1] + square[2]) - 1) < tolerance::no_direction))
    return Lanes{1, 0, 0, 0};
  return n;
}

using Rows = const float (&)[3][mesh_lanes];

// The products of the four columns from l on.
Lanes along(Lanes x, Lanes y, Lanes z, Rows rows, std::size_t l) {
  return x * load_four(rows[0] + l) + y * load_four(rows[1] + l) + z * load_four(rows[2] + l);
}

}  // namespace

void MeshRefit::Held::set_slab(Lanes low, Lanes high) {
  const float least = least_of(low), most = most_of(high);
  slab_mid = (least + most) / 2;
  // Twice: the height of a box's centre and its extent each have this error.
  slab_half = std::max(most - slab_mid, slab_mid - least) + static_cast<float>(2 * tolerance::height_of_floats);
}

MeshRefit::Box MeshRefit::box_of(const Held& held) const {
  const Lanes mid = (held.low + held.high) * all_four(0.5f);
  return {mid, max_of(held.high - mid, mid - held.low) + all_four(pad_)};
}

void MeshRefit::store_box(MeshNode& node, const Held& held) const {
  const Box box = box_of(held);
  for (int axis = 0; axis < 3; ++axis) node.box_mid[axis] = box.mid[axis], node.box_half[axis] = box.half[axis];
}

MeshRefit::Held MeshRefit::refit_bottom(MeshModel& mesh, MeshNode& node, Sums& sums) const {
  TriangleBlock& block = mesh.blocks[node.block];
  for (std::size_t c = 0; c < 3; ++c) {
    Lanes corner[mesh_lanes];
    for (std::size_t k = 0; k < mesh_lanes; ++k) corner[k] = corners_[leaves_[node.block][k][c]];
    store_rows(corner, block.corner[c]);
  }
  Lanes low[3], high[3], area[3], of_all[3] = {all_four(0), all_four(0), all_four(0)};
  for (int axis = 0; axis < 3; ++axis)
    low[axis] = all_four(std::numeric_limits<float>::infinity()), high[axis] = -low[axis], area[axis] = all_four(0);
  for (std::size_t l = 0; l < mesh_lanes; l += 4) {
    Lanes p[3], u[3], v[3], half[3];
    for (int axis = 0; axis < 3; ++axis) {
      const Lanes q = load_four(block.corner[1][axis] + l), r = load_four(block.corner[2][axis] + l);
      p[axis] = load_four(block.corner[0][axis] + l), u[axis] = q - p[axis], v[axis] = r - p[axis];
      const Lanes least = min_of(p[axis], min_of(q, r)), most = max_of(p[axis], max_of(q, r));
      low[axis] = min_of(low[axis], least), high[axis] = max_of(high[axis], most);
      half[axis] = (most - least) * all_four(0.5f) + all_four(pad_);
    }
    Lanes n[3];
    for (int i = 0, j = 1, k = 2; i < 3; j = k, k = i, ++i) {
      n[i] = only_in_use(u[j] * v[k] - u[k] * v[j], l, node.lanes());
      area[i] += n[i];
    }
    of_all[0] += p[0] * n[0] + p[1] * n[1] + p[2] * n[2];
    of_all[1] += only_in_use(half[0] * half[1] + half[1] * half[2] + half[2] * half[0], l, node.lanes());
    const Lanes reach = half[0] + half[1] + half[2];
    of_all[2] += reach * reach;
  }
  const Lanes sum = sums_of(of_all);
  sums.volumes += static_cast<double>(sum[0]);
  sums.leaves += static_cast<double>(sum[1]);
  sums.reaches += static_cast<double>(sum[2]);
  Held held;
  held.low = least_of_rows(low), held.high = most_of_rows(high), held.area = sums_of(area);
  store_box(node, held);
  held.normal = direction_of(held.area);
  const Lanes x = all_four(held.normal[0]), y = all_four(held.normal[1]), z = all_four(held.normal[2]);
  Lanes least = all_four(std::numeric_limits<float>::infinity()), most = -least;
  for (const auto& corner : block.corner)
    for (std::size_t l = 0; l < mesh_lanes; l += 4) {
      const Lanes at = along(x, y, z, corner, l);
      least = min_of(least, at), most = max_of(most, at);
    }
  held.set_slab(least, most);
  return held;
}

template <class Child>
MeshRefit::Held MeshRefit::refit_inner(MeshModel& mesh, MeshNode& node, Sums& sums, const Child& child) const {
  ChildBoxes& boxes = mesh.boxes[node.block];
  ChildSlabs& slabs = mesh.slabs[node.block];
  Held all;
  Lanes mid[mesh_lanes], half[mesh_lanes], normal[mesh_lanes], areas = all_four(0);
  for (std::uint32_t k = 0; k < mesh_lanes; ++k) {
    mid[k] = all_four(0), half[k] = all_four(-1e30f), normal[k] = all_four(0);  // overlaps nothing
    if (k >= node.lanes()) continue;
    const Held held = child(boxes.child[k]);
    const Box box = box_of(held);
    mid[k] = box.mid, half[k] = box.half, normal[k] = held.normal;
    slabs.mid[k] = held.slab_mid, slabs.half[k] = held.slab_half;
    areas += box.half * __builtin_shufflevector(box.half, box.half, 1, 2, 0, 3);
    all.low = min_of(all.low, held.low), all.high = max_of(all.high, held.high), all.area += held.area;
  }
  sums.inner += static_cast<double>(areas[0]) + static_cast<double>(areas[1]) + static_cast<double>(areas[2]);
  store_rows(mid, boxes.mid);
  store_rows(half, boxes.half);
  store_rows(normal, slabs.normal);
  store_box(node, all);
  all.normal = direction_of(all.area);
  const Lanes x = all_four(all.normal[0]), y = all_four(all.normal[1]), z = all_four(all.normal[2]);
  Lanes least = all_four(std::numeric_limits<float>::infinity()), most = -least;
  for (std::size_t l = 0; l < mesh_lanes; l += 4) {
    const Lanes at = along(x, y, z, boxes.mid, l), reach = along(absolute(x), absolute(y), absolute(z), boxes.half, l);
    least = min_of(least, at - reach), most = max_of(most, at + reach);
  }
  all.set_slab(least, most);
  return all;
}

MeshRefit::Held MeshRefit::refit_subtree(MeshModel& mesh, std::uint32_t n, Sums& sums) const {
  MeshNode& node = mesh.nodes[n];
  if (node.bottom()) return refit_bottom(mesh, node, sums);
  return refit_inner(mesh, node, sums, [&](std::uint32_t child) { return refit_subtree(mesh, child, sums); });
}

// Refits the nodes above the subtrees, which come in the order in which `cut` has found them.
MeshRefit::Held MeshRefit::refit_top(MeshModel& mesh, std::uint32_t n, std::size_t& next) {
  if (subtrees_[next].node == n) return subtrees_[next++].held;
  return refit_inner(mesh, mesh.nodes[n], top_sums_, [&](std::uint32_t child) { return refit_top(mesh, child, next); });
}

MeshRefit::Sums MeshRefit::sum_of_all() const {
  Sums all = top_sums_;
  for (const Subtree& s : subtrees_) {
    all.leaves += s.sums.leaves;
    all.volumes += s.sums.volumes;
    all.reaches += s.sums.reaches;
  }
  return all;
}

// The growth since it was built.
double MeshRefit::wear(double ratio, double& built) const {
  built = std::min(built, ratio);
  return built > 0 ? ratio / built : 1;
}

void MeshRefit::refit(MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts) {
  place_corners(mesh, vertices, parts, corners_);
  pad_ = mesh.corner_pad();
  run_parts(parts, subtrees_.size(), [&](std::size_t k) {
    Subtree& s = subtrees_[k];
    s.sums = {};
    s.held = refit_subtree(mesh, s.node, s.sums);
  });
  top_sums_ = {};
  std::size_t first = 0;
  refit_top(mesh, 0, first);
}

bool MeshRefit::surely_outward() const {
  const Sums all = sum_of_all();
  return all.volumes > tolerance::volume_rounding_of_floats * all.reaches;
}

MeshRefit::Report MeshRefit::rebuild_worn(MeshModel& mesh, const PartRunner& parts) {
  Report report;
  report.worn = wear(sum_of_all().ratio(), top_built_);
  std::vector<std::uint8_t> worn(subtrees_.size(), report.worn > worn_from ? 1 : 0);
  const bool all = report.worn > worn_from;
  for (std::size_t k = 0; k < subtrees_.size(); ++k) {
    const double its = wear(subtrees_[k].sums.ratio(), subtrees_[k].built);
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

// Rebuilds subtrees with enlarged boxes, and assembles the hierarchy from these, the others, and the nodes above all.
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

// The remaining subtrees keep the measure from when they were built.
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
         corners_.capacity() * sizeof(Lanes) + leaves_.capacity() * sizeof(leaves_[0]);
}

}  // namespace tandem
