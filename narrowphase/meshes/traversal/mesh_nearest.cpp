// The nearest points of two meshes, by branch and bound.
#include "meshes/traversal/mesh_nearest.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory_resource>
#include <span>

#include "meshes/traversal/hierarchy.h"
#include "pairs/convex_pair.h"
#include "shapes/lent_memory.h"
#include "shapes/mesh_model.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "shapes/skewness.h"
#include "shapes/triangle_height.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

// For nearly parallel edges, whose crossing depends on rounding.
void ends_nearest(const Vec3& p, const Vec3& d, const Vec3& q, const Vec3& e, Nearest& best) {
  const Vec3 r = p - q;
  const double dd = d.squaredNorm(), ee = e.squaredNorm(), f = e.dot(r), c = d.dot(r), b = d.dot(e);
  const auto along = [](double over, double under) { return under > 0 ? std::clamp(over / under, 0.0, 1.0) : 0.0; };
  const auto take = [&](double s, double t) { best.take(p + s * d, q + t * e); };
  for (const double end : {0.0, 1.0}) take(end, along(b * end + f, ee)), take(along(b * end - c, dd), end);
  // The crossing from products that do not cancel as their squares do, with an error of epsilon over the sine.
  const Vec3 x = e.cross(d.cross(e));
  const double crossing = along(-r.dot(x), d.dot(x));
  take(crossing, along(b * crossing + f, ee));
}

// The projection of v on the plane of a triangle, if inside. Edges are handled by the segments.
void vertex_nearest(const Vec3& v, const TriangleFrame& t, bool v_of_a, Nearest& best) {
  if (!(t.height2 > 0)) return;
  const Vec3 r = v - t.from;
  const double up = r.dot(t.height) / t.height2, along = (r - up * t.slant).dot(t.side) / t.side2;
  if (!(up >= 0 && along >= 0 && up + along <= 1)) return;
  const Vec3 foot = t.from + up * t.slant + along * t.side;
  v_of_a ? best.take(v, foot) : best.take(foot, v);
}

// The centre of a box, in the mesh's units.
Vec3 middle_of(const MeshModel& mesh, const MeshNode& node, std::uint32_t lane) {
  Vec3 middle;
  if (!node.bottom()) {
    const ChildBoxes& boxes = mesh.boxes_of(node);
    for (int axis = 0; axis < 3; ++axis) middle[axis] = static_cast<double>(boxes.mid[axis][lane]);
    return middle;
  }
  const TriangleBlock& block = mesh.blocks[node.block];
  for (int axis = 0; axis < 3; ++axis) {
    const float p = block.corner[0][axis][lane], q = block.corner[1][axis][lane], r = block.corner[2][axis][lane];
    middle[axis] = static_cast<double>((std::min({p, q, r}) + std::max({p, q, r})) * 0.5f);
  }
  return middle;
}

// The square of half a box's diagonal; 0 for a triangle.
double half_square(const MeshModel& mesh, std::uint32_t ref) {
  if (lane_of(ref) == whole) return mesh.half.squaredNorm();
  const ChildBoxes& boxes = mesh.boxes_of(mesh.nodes[node_of(ref)]);
  double sum = 0;
  for (const auto& half : boxes.half)
    sum += static_cast<double>(half[lane_of(ref)]) * static_cast<double>(half[lane_of(ref)]);
  return mesh.unit * mesh.unit * sum;
}

// The normal of two triangles that do not intersect. Of two in one plane (to `slack`) rounding decides which lies
// ahead: there it points out of the solids whose faces they are.
Vec3 towards_outside(const Vec3& normal, const FaceOf& a, const FaceOf& b, double slack) {
  const Vec3 n_a = a.pose.rotation.transpose() * normal, n_b = b.pose.rotation.transpose() * normal;
  const double offset = normal.dot(b.pose.translation - a.pose.translation);
  if (most_along(n_b, b.corners) + offset - least_along(n_a, a.corners) > slack) return normal;
  const auto rise = [](const FaceOf& face, const Vec3& n) {
    return face.of_solid ? n.dot(area_vector(face.corners).stableNormalized()) : 0;
  };
  return rise(a, n_a) < rise(b, n_b) ? Vec3(-normal) : normal;
}

// True if two edges across the direction cross each other, of one triangle or of both: then it is no difference of
// points, which rounding turns.
bool is_given_by_edges(const Vec3& n, const PlacedTriangle& p, const PlacedTriangle& q) {
  std::array<Vec3, 6> across;
  std::size_t count = 0;
  for (const PlacedTriangle* t : {&p, &q})
    for (std::size_t i = 0; i < 3; ++i)
      if (const Vec3 e = t->edge(i); std::abs(n.dot(e)) <= tolerance::parallel_lines * e.norm()) across[count++] = e;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (across[i].cross(across[j]).squaredNorm() >
          tolerance::slanting2 * across[i].squaredNorm() * across[j].squaredNorm())
        return true;
  return false;
}

// A mesh in the other's frame: relative to its centre, in its units.
MeshView view_of(const MeshModel& mesh, const MeshModel& by, const Mat3& turn, const Vec3& shift) {
  return {mesh, turn, (turn * mesh.centre + shift - by.centre) / by.unit, by.unit};
}

}  // namespace

TriangleFrame::TriangleFrame(const Corners& t) {
  const double length2[3] = {(t[1] - t[0]).squaredNorm(), (t[2] - t[1]).squaredNorm(), (t[0] - t[2]).squaredNorm()};
  const std::size_t i = length2[0] >= length2[1] && length2[0] >= length2[2] ? 0 : length2[1] >= length2[2] ? 1 : 2;
  from = t[i];
  side = t[(i + 1) % 3] - from;
  slant = t[(i + 2) % 3] - from;
  side2 = length2[i];
  height = Height(side, slant).height;
  height2 = height.squaredNorm();
}

PlacedTriangle::PlacedTriangle(const Corners& t) : corner(t), frame(t) {
  for (std::size_t j = 0; j < 4; ++j) {
    const Vec3 edge = t[(j + 1) % 3] - t[j % 3];
    for (int k = 0; k < 3; ++k) edges.corner[k][j] = t[j % 3][k], edges.edge[k][j] = edge[k];
    edges.length2[j] = edge.squaredNorm();
  }
}

void triangles_nearest(const PlacedTriangle& p, const PlacedTriangle& q, Nearest& best) {
  EdgePairs pairs;
  nearest_on_edges(p.edges, q.edges, pairs);
  for (std::size_t i = 0; i < 3; ++i) {
    vertex_nearest(p.corner[i], q.frame, true, best);
    vertex_nearest(q.corner[i], p.frame, false, best);
    for (std::size_t j = 0; j < 3; ++j) {
      if (best.may_take(pairs.squared[i][j]))
        best.take(p.corner[i] + pairs.on_a[i][j] * p.edge(i), q.corner[j] + pairs.on_b[i][j] * q.edge(j));
      if ((pairs.parallel >> (4 * i + j) & 1u) != 0) ends_nearest(p.corner[i], p.edge(i), q.corner[j], q.edge(j), best);
    }
  }
}

void triangles_nearest(const Corners& p, const Corners& q, Nearest& best) {
  triangles_nearest(PlacedTriangle(p), PlacedTriangle(q), best);
}

Vec3 direction_between(const Nearest& near, const FaceOf& a, const FaceOf& b, double reach,
                       const NarrowPhaseOptions& options) {
  if (!(near.distance > tolerance::noisy_difference * reach)) {
    const PairAnswer r = solve_convex(TriangleView(a.corners), a.pose, TriangleView(b.corners), b.pose,
                                      Request::distance, options, nullptr);
    if (r.normal.norm() > 0.5) return towards_outside(r.normal, a, b, tolerance::undecided * reach);
    if (!(near.distance > 0)) return Vec3::UnitZ();
  }
  return unit(near.on_b - near.on_a, near.distance);
}

double rounding_of_corners(const MeshModel& a, const MeshModel& b, const Vec3& between) {
  return tolerance::place_rounding * (reach(a) + reach(b) + between.lpNorm<1>());
}

Vec3 direction_of(TouchingFaces& near, double gap, double rounding, const Vec3& own) {
  // The direction of so short a gap is rounded itself.
  const Vec3 first = gap > rounding ? own : Vec3(Vec3::Zero());
  if (near.separate(first)) return near.direction();
  if (Vec3 off; !(gap > rounding) && !near.leave_faces(rounding, false, off).empty()) return unit(off, off.norm());
  return near.normal_near(own);
}

NearestSearch::NearestSearch(const Posed& a, const Posed& b, const WorkLimit* limit)
    : a_(mesh_of(a.shape)),
      b_(mesh_of(b.shape)),
      turn_a_(a.pose.rotation),
      turn_b_(b.pose.rotation),
      between_(b.pose.translation - a.pose.translation),
      a_by_b_(view_of(a_, b_, turn_b_.transpose() * turn_a_, -(turn_b_.transpose() * between_))),
      b_by_a_(view_of(b_, a_, turn_a_.transpose() * turn_b_, turn_a_.transpose() * between_)),
      // If the rotations are not orthonormal, boxes may be nearer than they seem.
      rounding_(rounding_of_corners(a_, b_, between_)),
      slack_(12 * (skewness(turn_a_) + skewness(turn_b_)) * (reach(a_) + reach(b_) + between_.lpNorm<1>()) + rounding_),
      meter_(limit) {}

Nearest NearestSearch::operator()(double cutoff) {
  const double within = cutoff + slack_;
  best_.distance = within;
  // Each level leaves all children but one.
  std::array<Item, 2 * most_mesh_levels * mesh_lanes> stack;
  std::size_t top = 0;
  stack[top++] = {0, whole, whole};
  while (top > 0) {
    const Item at = stack[--top];
    if (!(at.bound <= best_.distance)) continue;
    meter_.spend(4);
    if (is_leaf(a_, at.a) && is_leaf(b_, at.b)) {
      solve(leaf_triangle(a_, at.a), leaf_triangle(b_, at.b));
      continue;
    }
    const Children children = bounds_of_children(at, best_.distance);
    const bool down_a = children.of_a;
    const MeshModel& mesh = down_a ? a_ : b_;
    const MeshNode& node = mesh.nodes[children.node];
    const std::size_t first = top;
    // Equally near boxes, such as overlapping ones, are ordered by the distance of their centres.
    const auto away = [&](const Item& item) {
      return (middle_of(mesh, node, lane_of(down_a ? item.a : item.b)) - children.aligned_mid).squaredNorm();
    };
    for (std::uint32_t k = 0; k < node.lanes(); ++k) {
      const double bound = std::max(at.bound, children.bound[k]);
      if (!(bound <= best_.distance)) continue;
      const std::uint32_t child = child_ref(children.node, k);
      const Item item = down_a ? Item{bound, child, at.b} : Item{bound, at.a, child};
      // The nearest on top.
      std::size_t place = top++;
      for (; place > first; --place) {
        const Item& below = stack[place - 1];
        if (below.bound > bound || (below.bound == bound && away(below) > away(item))) break;
        stack[place] = below;
      }
      stack[place] = item;
    }
  }
  if (!(best_.distance < within)) best_.distance = infinity;
  return best_;
}

bool NearestSearch::goes_down_a(const Item& at) const {
  return is_leaf(b_, at.b) || (!is_leaf(a_, at.a) && half_square(a_, at.a) >= half_square(b_, at.b));
}

NearestSearch::Children NearestSearch::bounds_of_children(const Item& at, double within) {
  const bool down_a = goes_down_a(at);
  const MeshModel& mesh = down_a ? a_ : b_;
  const NearVolume& volume = down_a ? seen_b_.at(at.b) : seen_a_.at(at.a);
  const Vec3 ahead = down_a ? Vec3(-normal_a_) : normal_b_;
  Children children{down_a, node_under(mesh, down_a ? at.a : at.b), {}, volume.aligned_mid};
  const double off = slack_ + bounds_off * mesh.unit;
  const double enough = (within + off) / mesh.unit * (1 + 8 * epsilon);
  bound_distances(volume, {ahead, volume.reach(ahead)}, mesh, mesh.nodes[children.node], enough, children.bound);
  for (double& bound : children.bound) bound = mesh.unit * bound - off;
  return children;
}

const PlacedTriangle& NearestSearch::placed_of_a(std::uint32_t triangle) {
  if (triangle != last_a_.triangle) {
    Corners p = a_.corners(triangle);
    for (Vec3& corner : p) corner = turn_a_ * corner;
    last_a_ = {triangle, PlacedTriangle(p)};
  }
  return last_a_.placed;
}

const PlacedTriangle& NearestSearch::placed_of_b(std::uint32_t triangle) {
  if (triangle != last_b_.triangle) {
    Corners q = b_.corners(triangle);
    for (Vec3& corner : q) corner = turn_b_ * corner + between_;
    last_b_ = {triangle, PlacedTriangle(q)};
  }
  return last_b_.placed;
}

bool NearestSearch::each_within(double within, const Meet& meet, const Visit& visit,
                                const std::function<void(double)>& progress, const LeaveOut& leave_out) {
  constexpr double steps = 128;  // of progress
  struct Part {
    Item at;
    double share;  // of all the work, if all children took equally long
  };
  std::array<Part, 2 * most_mesh_levels * mesh_lanes> stack;
  std::size_t top = 0;
  stack[top++] = {{0, whole, whole}, 1};
  double done = 0, reported = 0;
  const auto finish = [&](double share) {
    done += share;
    if (!progress || (done < reported + 1 / steps && top > 0)) return;
    progress(reported = top > 0 ? std::min(done, 1.0) : 1);
  };
  while (top > 0) {
    const auto [at, share] = stack[--top];
    meter_.spend(4);
    if (leave_out && leave_out(at)) {
      finish(share);
      continue;
    }
    if (is_leaf(a_, at.a) && is_leaf(b_, at.b)) {
      const TrianglePair pair{leaf_triangle(a_, at.a), leaf_triangle(b_, at.b)};
      Nearest nearest;
      if (meet(pair[0], pair[1])) {
        nearest.distance = 0;
      } else {
        triangles_nearest(placed_of_a(pair[0]), placed_of_b(pair[1]), nearest);
        nearest.distance = std::max(nearest.distance, std::numeric_limits<double>::min());
      }
      if (nearest.distance <= within && !visit(pair, nearest)) return false;
      finish(share);
      continue;
    }
    const Children children = bounds_of_children(at, within);
    const std::uint32_t lanes = (children.of_a ? a_ : b_).nodes[children.node].lanes();
    for (std::uint32_t k = lanes; k-- > 0;) {
      if (!(children.bound[k] <= within)) continue;
      const std::uint32_t child = child_ref(children.node, k);
      stack[top++] = {children.of_a ? Item{0, child, at.b} : Item{0, at.a, child}, share / lanes};
    }
    const auto left = static_cast<double>(std::count_if(children.bound.begin(), children.bound.begin() + lanes,
                                                        [&](double bound) { return !(bound <= within); }));
    finish(share * left / lanes);
  }
  return true;
}

void NearestSearch::solve(std::uint32_t i, std::uint32_t j) {
  const PlacedTriangle &p = placed_of_a(i), &q = placed_of_b(j);
  if (least_along(normal_, q.corner) + least_along(-normal_, p.corner) > best_.distance + slack_) return;
  // The first by index of equally near pairs, so that the order of the search does not matter.
  Nearest found;
  found.leave_out_beyond(best_.distance + rounding_);
  triangles_nearest(p, q, found);
  const TrianglePair pair{i, j};
  add_tie(pair, found.distance);
  if (!(found.distance < best_.distance || (found.distance == best_.distance && pair < nearest_))) return;
  best_ = found;
  nearest_ = pair;
  if (best_.distance == 0) return;
  normal_ = unit(best_.on_b - best_.on_a, best_.distance);
  normal_a_ = turn_a_.transpose() * normal_;
  normal_b_ = turn_b_.transpose() * normal_;
}

void NearestSearch::add_tie(const TrianglePair& pair, double distance) {
  if (!(distance <= best_.distance + rounding_)) return;
  if (distance < best_.distance) {
    const auto farther = [&](const Tie& t) { return t.distance > distance + rounding_; };
    tie_count_ =
        static_cast<std::size_t>(std::remove_if(ties_.begin(), ties_.begin() + tie_count_, farther) - ties_.begin());
  }
  if (tie_count_ < most_ties)
    ties_[tie_count_++] = {pair, distance};
  else
    least_left_out_ = std::min(least_left_out_, distance);
}

bool NearestSearch::separates_ties(const Vec3& n) const {
  const Vec3 n_a = turn_a_.transpose() * n, n_b = turn_b_.transpose() * n;
  return std::all_of(ties_.begin(), ties_.begin() + tie_count_, [&](const Tie& t) {
    const double ahead =
        n.dot(between_) + least_along(n_b, b_.corners(t.pair[1])) - most_along(n_a, a_.corners(t.pair[0]));
    return ahead >= best_.distance - rounding_;
  });
}

bool NearestSearch::take_separating_tie(const NarrowPhaseOptions& options, Nearest& points, Vec3& n) {
  constexpr std::size_t most_tries = 16;
  const std::span ties = std::span(ties_).first(tie_count_);
  std::sort(ties.begin(), ties.end(), [](const Tie& p, const Tie& q) { return p.pair < q.pair; });
  for (const Tie& tie : ties.first(std::min(tie_count_, most_tries))) {
    meter_.spend(16);
    const PairAnswer r =
        solve_convex(TriangleView(a_.corners(tie.pair[0])), {turn_a_, Vec3::Zero()},
                     TriangleView(b_.corners(tie.pair[1])), {turn_b_, between_}, Request::distance, options, nullptr);
    if (std::abs(r.signed_distance - best_.distance) > rounding_ || !separates_ties(r.normal)) continue;
    points.on_a = r.point_a;
    points.on_b = r.point_b;
    n = r.normal;
    return true;
  }
  return false;
}

Vec3 NearestSearch::normal(const NarrowPhaseOptions& options, Nearest& points) {
  const double reach_of_both = reach(a_) + reach(b_), gap = best_.distance;
  const bool far = gap > tolerance::noisy_difference * reach_of_both;
  Vec3 own = direction_between(best_, {a_.corners(nearest_[0]), {turn_a_, Vec3::Zero()}, a_.solid},
                               {b_.corners(nearest_[1]), {turn_b_, between_}, b_.solid}, reach_of_both, options);
  if (gap > rounding_ && has_all_ties() && (separates_ties(own) || take_separating_tie(options, points, own)))
    return own;
  if (far || (gap > rounding_ && is_given_by_edges(own, placed_of_a(nearest_[0]), placed_of_b(nearest_[1]))))
    return own;
  alignas(std::max_align_t) std::array<std::byte, std::size_t{16} << 10> usual;
  std::pmr::monotonic_buffer_resource memory(usual.data(), usual.size(), lent_memory(options));
  TouchingFaces near(a_, b_, gap, rounding_, meter_, &memory);
  const auto add = [&](const TrianglePair& pair, const Nearest&) {
    near.add(pair, placed_of_a(pair[0]).corner, placed_of_b(pair[1]).corner);
    return near.size() < most_touching;
  };
  const bool all = each_within(gap + rounding_, [](std::uint32_t, std::uint32_t) { return false; }, add, {});
  if (!all) return own;
  return direction_of(near, gap, rounding_, own);
}

}  // namespace tandem
