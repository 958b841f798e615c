// Voxels and another shape: the requests.
#include "dispatch/voxel_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory_resource>
#include <optional>
#include <queue>
#include <span>
#include <utility>

#include "dispatch/voxel_gap.h"
#include "manifold/patch_collector.h"
#include "manifold/patch_point.h"
#include "meshes/mesh_solvers.h"
#include "meshes/traversal/least_translation.h"
#include "shapes/lent_memory.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "shapes/work_meter.h"
#include "tandem/narrowphase/clearance.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// The result over all cells: the least distance, and how deep the other shape is at least.
struct CellsFound {
  PairAnswer nearest;
  double certain = 0;  ///< no shorter translation separates
  double most = 0;     ///< no cell is deeper; infinite: not known

  CellsFound() { nearest.signed_distance = infinity; }
  void take(const PairAnswer& answer) {
    if (answer.status != Status::unproven) certain = std::max(certain, -answer.signed_distance - answer.error_bound);
    most = answer.status == Status::unproven ? infinity : std::max(most, answer.error_bound - answer.signed_distance);
    if (answer.signed_distance < nearest.signed_distance) nearest = answer;
  }
};

/// The feature of a cell's k-th contact.
std::uint32_t feature_of_cell(VoxelRef cell, std::size_t k) {
  return static_cast<std::uint32_t>(cell * contacts_of_one + std::min<std::size_t>(k, contacts_of_one - 1));
}

/// The boxes of the cells of each level for voxels with rounding; otherwise empty.
std::vector<Shape> rounded_boxes(const Shape& voxels) {
  std::vector<Shape> boxes;
  if (voxels.kind() == ShapeKind::voxels && voxels.rounding() > 0)
    for (const Shape& box : voxels_of(voxels).boxes) boxes.push_back(box.rounded(voxels.rounding()));
  return boxes;
}

/// Voxels (A) and another shape, in world axes about the voxels' origin.
class VoxelPair {
 public:
  VoxelPair(const Shape& voxels, const Pose& pose, const Shape& other, const Pose& other_pose,
            const NarrowPhaseOptions& options)
      : VoxelPair(voxels, pose, other, other_pose, options, nullptr) {
    own_boxes_ = rounded_boxes(voxels);
    other_boxes_ = rounded_boxes(other);
  }

  /// `boxes`: the rounded boxes of the voxels, made by another pair; null: none.
  VoxelPair(const Shape& voxels, const Pose& pose, const Shape& other, const Pose& other_pose,
            const NarrowPhaseOptions& options, const std::vector<Shape>* boxes)
      : voxels_(voxels),
        model_(voxels_of(voxels)),
        pose_(pose),
        other_(other),
        other_pose_(other_pose),
        options_(options),
        gap_(voxels, pose, other, other_pose, options.limit),
        meter_(options.limit),
        rounded_boxes_(boxes != nullptr ? *boxes : own_boxes_) {}
  VoxelPair(const VoxelPair&) = delete;
  VoxelPair& operator=(const VoxelPair&) = delete;

  bool collide() {
    return !model_.each_cell(
        [&](VoxelRef ref) { return is_near(ref, 0); },
        [&](VoxelRef cell) { return !solve_cell(cell, Request::collide, options_, nullptr).collide; });
  }

  /// The least distance of a cell; cells beyond the cut-off need not be found.
  CellsFound nearest(double cutoff);

  /// Gathers the contacts of each cell: visit(cell, contacts); those of places that other cells cover are left out.
  template <class Visit>
  CellsFound each_contact(Visit&& visit);

  PairAnswer distance() {
    const CellsFound found = nearest(options_.cutoff);
    const bool is_apart = found.nearest.farther || found.nearest.signed_distance > 0;
    return is_apart ? found.nearest : depth(found);
  }
  PairAnswer contacts(std::vector<Contact>& out);

 private:
  /// True if a cell, or one below a node, may be within; by the other shape's hierarchy if its box leaves it open.
  bool is_near(VoxelRef ref, double within) {
    meter_.spend();
    if (!(gap_(ref, within) <= within)) return false;
    if (other_.is_convex() || model_.is_cell(ref) || within == infinity) return true;
    const auto [mid, half] = model_.box(ref);
    const Shape box = Shape(Box{2 * (half + Vec3::Constant(gap_.slack()))}).rounded(voxels_.rounding());
    // The verdict first: the distance of overlapping shapes would be a depth.
    const bool touches = solve_pair(box, at(mid), other_, other_pose_, Request::collide, options_, nullptr).collide;
    if (touches || within == 0) return touches;
    NarrowPhaseOptions options = for_triangles(options_);
    options.cutoff = within;
    return !solve_pair(box, at(mid), other_, other_pose_, Request::distance, options, nullptr).farther;
  }

  Pose at(const Vec3& local) const { return {pose_.rotation, pose_ * local}; }

  PairAnswer solve_cell(VoxelRef cell, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts);
  const Shape& box_of(VoxelRef cell) const {
    return rounded_boxes_.empty() ? model_.box_of(cell) : rounded_boxes_[model_.cells[cell].level];
  }
  Vec3 in_cells(const Vec3& point) const;
  std::array<std::int64_t, 3> nearest_of(VoxelRef cell, const Vec3& places) const;
  bool is_covered(VoxelRef cell, const Contact& contact) const;
  PairAnswer depth(const CellsFound& found) const;
  std::optional<Vec3> off_cells() const;
  bool add_contacts(const Vec3& moved_by, LocalConstraints& off);
  bool add_free_face(const Vec3& moved_by, LocalConstraints& off);
  Constraint off_free_face(VoxelRef cell, const Vec3& point) const;
  PairAnswer depth_of_plane(double certain) const;
  bool has_covered_contact_across(const Vec3& normal) const;
  void replace_patch(const PairAnswer& whole, std::vector<Contact>& out, std::size_t first);
  bool separates(const Vec3& translation) const;
  double slack() const { return tolerance::translation_slack * (voxels_.size() + other_.size()); }

  const Shape& voxels_;
  const VoxelModel& model_;
  const Pose pose_;
  const Shape& other_;
  const Pose other_pose_;
  const NarrowPhaseOptions& options_;
  const VoxelGap gap_;
  WorkMeter meter_;
  std::vector<Shape> own_boxes_, other_boxes_;
  const std::vector<Shape>& rounded_boxes_;  // by level, of voxels with rounding
  std::vector<Contact> of_cell_;
  std::vector<Vec3> covered_normals_;  // normals of contacts at covered points
};

PairAnswer VoxelPair::solve_cell(VoxelRef cell, Request request, const NarrowPhaseOptions& options,
                                 std::vector<Contact>* contacts) {
  meter_.spend(4);
  const Shape& box = box_of(cell);
  const Pose pose = at(model_.centre(cell));
  if (other_.kind() != ShapeKind::voxels) return solve_pair(box, pose, other_, other_pose_, request, options, contacts);
  VoxelPair cells(other_, other_pose_, box, pose, options, &other_boxes_);
  PairAnswer answer;
  if (request == Request::collide) {
    answer.collide = cells.collide();
    return answer;
  }
  if (request == Request::distance) {
    answer = cells.nearest(options.cutoff).nearest;
  } else {
    answer = cells
                 .each_contact([&](VoxelRef, std::span<const Contact> found) {
                   contacts->insert(contacts->end(), found.begin(), found.end());
                 })
                 .nearest;
  }
  swap_answer(answer, contacts, 0);
  return answer;
}

CellsFound VoxelPair::nearest(double cutoff) {
  struct Waiting {
    double bound;
    VoxelRef ref;
    bool operator<(const Waiting& o) const { return bound != o.bound ? bound > o.bound : ref > o.ref; }
  };
  alignas(Waiting) std::array<std::byte, 128 * sizeof(Waiting)> usual;
  std::pmr::monotonic_buffer_resource memory(usual.data(), usual.size(), lent_memory(options_));
  std::pmr::vector<Waiting> list(&memory);
  list.reserve(128);
  std::priority_queue<Waiting, std::pmr::vector<Waiting>> queue(std::less<Waiting>(), std::move(list));
  CellsFound found;
  NarrowPhaseOptions of_cell = for_triangles(options_);
  of_cell.cutoff = infinity;
  const auto wanted = [&] { return std::min(cutoff, std::max(0.0, found.nearest.signed_distance)); };
  const auto push = [&](VoxelRef ref) {
    meter_.spend();
    const double enough = std::min(cutoff, found.nearest.signed_distance);
    if (const double bound = gap_(ref, enough); bound <= cutoff && bound < found.nearest.signed_distance)
      queue.push({bound, ref});
  };
  push(model_.root());
  while (!queue.empty() && queue.top().bound < found.nearest.signed_distance) {
    const VoxelRef ref = queue.top().ref;
    queue.pop();
    if (model_.is_cell(ref)) {
      if (!other_.is_convex()) of_cell.cutoff = wanted();
      const PairAnswer answer = solve_cell(ref, Request::distance, of_cell, nullptr);
      if (!answer.farther && answer.signed_distance <= cutoff) found.take(answer);
    } else if (other_.is_convex() || is_near(ref, wanted())) {
      const VoxelModel::Node& node = model_.node(ref);
      for (std::uint32_t k = 0; k < node.count; ++k) push(node.first + k);
    }
  }
  if (found.nearest.signed_distance > cutoff) {
    found.nearest = {};
    found.nearest.farther = true;
    found.nearest.signed_distance = cutoff;
  }
  return found;
}

/// A point in the grid's coordinates, in edges of a smallest cell.
Vec3 VoxelPair::in_cells(const Vec3& point) const {
  return (pose_.rotation.transpose() * (point - pose_.translation) - model_.origin) / model_.cell_size;
}

/// The smallest cell within this one that is nearest to a place in the grid.
std::array<std::int64_t, 3> VoxelPair::nearest_of(VoxelRef cell, const Vec3& places) const {
  const auto [lo, hi] = model_.span_of(cell);
  std::array<std::int64_t, 3> nearest;
  for (std::size_t k = 0; k < 3; ++k) {
    const double place = std::clamp<double>(places[static_cast<Eigen::Index>(k)], lo[k], hi[k]);
    nearest[k] = std::clamp(static_cast<std::int64_t>(std::floor(place)), std::int64_t{lo[k]}, std::int64_t{hi[k]} - 1);
  }
  return nearest;
}

/// True if another cell covers the contact's point on this one, on the side to which it pushes.
bool VoxelPair::is_covered(VoxelRef cell, const Contact& contact) const {
  const Vec3 on_surface = contact.point + (contact.depth / 2 - voxels_.rounding()) * contact.normal;
  const Vec3 places = in_cells(on_surface), normal = pose_.rotation.transpose() * contact.normal;
  const auto [lo, hi] = model_.span_of(cell);
  const std::array<std::int64_t, 3> inside = nearest_of(cell, places);
  std::array<std::int64_t, 3> beyond;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const double place = places[axis];
    const bool above = normal[axis] > tolerance::on_cell && place > hi[k] - tolerance::on_cell,
               below = normal[axis] < -tolerance::on_cell && place < lo[k] + tolerance::on_cell;
    beyond[k] = above ? hi[k] : below ? lo[k] - 1 : inside[k];
  }
  // A point on an edge or in a corner is covered by the cell beyond any of its faces.
  for (unsigned axes = 1; axes < 8; ++axes) {
    std::array<std::int64_t, 3> at = inside;
    for (std::size_t k = 0; k < 3; ++k)
      if ((axes >> k & 1u) != 0) at[k] = beyond[k];
    if (at != inside && model_.has(at)) return true;
  }
  return false;
}

template <class Visit>
CellsFound VoxelPair::each_contact(Visit&& visit) {
  CellsFound found;
  const NarrowPhaseOptions of_cell = for_triangles(options_);
  model_.each_cell([&](VoxelRef ref) { return is_near(ref, options_.margin); },
                   [&](VoxelRef cell) {
                     of_cell_.clear();
                     const PairAnswer answer = solve_cell(cell, Request::contacts, of_cell, &of_cell_);
                     // Of a cell and voxels all contacts may be left out as covered: the answer is there all the same.
                     const bool cells_of_other = other_.kind() == ShapeKind::voxels;
                     if (cells_of_other ? std::isinf(answer.signed_distance) : of_cell_.empty()) return true;
                     found.take(answer);
                     std::erase_if(of_cell_, [&](const Contact& c) {
                       const bool covered = is_covered(cell, c);
                       if (covered) covered_normals_.push_back(c.normal);
                       return covered;
                     });
                     if (!of_cell_.empty()) visit(cell, std::span<const Contact>(of_cell_));
                     return true;
                   });
  return found;
}

bool VoxelPair::separates(const Vec3& translation) const {
  const Pose moved{other_pose_.rotation, other_pose_.translation + translation};
  return !VoxelPair(voxels_, pose_, other_, moved, options_).collide();
}

/// A plane leaves all cells on one side or the other.
PairAnswer VoxelPair::depth_of_plane(double certain) const {
  PairAnswer best;
  best.signed_distance = -infinity;
  for (const double sense : {1.0, -1.0}) {
    const Shape side = HalfSpace{sense * other_.normal(), sense * other_.offset() + other_.rounding()};
    const PairAnswer out = VoxelPair(voxels_, pose_, side, other_pose_, options_).nearest(infinity).nearest;
    if (out.signed_distance > best.signed_distance) best = out;
  }
  const double off = -best.signed_distance - certain;
  if (off > slack()) best.status = Status::inexact, best.error_bound = off;
  return best;
}

/// Off a cell along an axis of the grid, through the face with no other cell beside the point whose translation is the
/// shortest; an infinite one where there is none.
Constraint VoxelPair::off_free_face(VoxelRef cell, const Vec3& point) const {
  Constraint best{Vec3::UnitX(), infinity};
  const auto [lo, hi] = model_.span_of(cell);
  const std::array<std::int64_t, 3> inside = nearest_of(cell, in_cells(point));
  NarrowPhaseOptions options;
  options.limit = options_.limit;
  for (std::size_t k = 0; k < 3; ++k)
    for (const bool above : {true, false}) {
      std::array<std::int64_t, 3> beside = inside;
      beside[k] = above ? hi[k] : lo[k] - 1;
      if (model_.has(beside)) continue;
      const Vec3 n = (above ? 1 : -1) * pose_.rotation.col(static_cast<Eigen::Index>(k)).normalized();
      const double length = separation_along(box_of(cell), at(model_.centre(cell)), other_, other_pose_, n, options);
      if (length < best.bound) best = {n, length};
    }
  return best;
}

/// Adds what takes the other shape, which was moved, off each cell that it touches: the contacts that push out of the
/// voxels. False: nothing new.
bool VoxelPair::add_contacts(const Vec3& moved_by, LocalConstraints& off) {
  bool is_new = false;
  each_contact(
      [&](VoxelRef, std::span<const Contact> list) { is_new = off.add_contacts(list, moved_by, 0) || is_new; });
  return is_new;
}

/// Adds what takes it off one of the cells whose contacts push into other cells, along the grid, through a face with no
/// cell beside it: of these the shortest translation, which may lead off the rest, too. False: nothing new.
bool VoxelPair::add_free_face(const Vec3& moved_by, LocalConstraints& off) {
  Constraint nearest{Vec3::UnitX(), infinity};
  const NarrowPhaseOptions of_cell = for_triangles(options_);
  model_.each_cell([&](VoxelRef ref) { return is_near(ref, 0); },
                   [&](VoxelRef cell) {
                     of_cell_.clear();
                     const PairAnswer answer = solve_cell(cell, Request::contacts, of_cell, &of_cell_);
                     if (!answer.collide || of_cell_.empty()) return true;
                     const Constraint face = off_free_face(cell, of_cell_.front().point);
                     if (face.bound < nearest.bound) nearest = face;
                     return true;
                   });
  return nearest.bound < infinity &&
         off.add({{nearest.normal, nearest.normal.dot(moved_by) + nearest.bound}, infinity, Vec3::Zero()});
}

/// A translation that separates, off all cells at once, as in a corner between them; none where these contradict each
/// other.
std::optional<Vec3> VoxelPair::off_cells() const {
  NarrowPhaseOptions touching = options_;
  touching.margin = slack();
  const auto add = [&](const Vec3& at, int round, LocalConstraints& off) {
    const Pose moved{other_pose_.rotation, other_pose_.translation + at};
    VoxelPair there(voxels_, pose_, other_, moved, touching);
    const bool by_contacts = there.add_contacts(at, off);
    // After some rounds in any case: contacts of two cells may push back onto each other, by less and less.
    constexpr int first_rounds = 4;
    const bool by_face = (!by_contacts || round >= first_rounds) && there.add_free_face(at, off);
    return by_contacts || by_face;
  };
  const double little = tolerance::alike * (voxels_.size() + other_.size());
  const OffPrecision precision{slack() / 8, slack() / 2, slack() / 2, little};
  return translation_off_all(Vec3::Zero(), precision, add, [&](const Vec3& at) { return !separates(at); });
}

/// A translation that separates from all cells: along the normal of the deepest, off all that touch, along the axes of
/// the grid.
PairAnswer VoxelPair::depth(const CellsFound& found) const {
  const PairAnswer& deepest = found.nearest;
  if (other_.kind() == ShapeKind::halfspace) return deepest;
  if (other_.kind() == ShapeKind::plane) return depth_of_plane(found.certain);
  NarrowPhaseOptions options;
  options.limit = options_.limit;
  double shortest = infinity;
  Vec3 along = deepest.normal;
  const auto attempt = [&](const Vec3& direction) {
    if (shortest <= found.certain + slack() || !(direction.squaredNorm() > 0)) return;
    const double out = separation_along(voxels_, pose_, other_, other_pose_, direction, options);
    if (out < shortest) shortest = out, along = direction;
  };
  attempt(deepest.normal);
  if (shortest <= -deepest.signed_distance + slack()) {
    PairAnswer answer = deepest;
    const double off = -deepest.signed_distance - found.certain;
    answer.error_bound = off > slack() ? off : 0;
    answer.status = off > slack() ? Status::inexact : Status::ok;
    return answer;
  }
  if (const auto off = off_cells(); off && off->norm() < shortest) shortest = off->norm(), along = *off / shortest;
  for (int k = 0; k < 3; ++k)
    for (const double sense : {1.0, -1.0}) attempt(sense * pose_.rotation.col(k).normalized());
  PairAnswer answer;
  answer.collide = true;
  answer.normal = along;
  const double off = shortest - found.certain;
  if (off > slack())
    answer.status = Status::inexact, answer.error_bound = off;
  else
    shortest = found.certain;  // without the margin for rounding
  answer.signed_distance = -shortest;
  // The point of the last touch on the voxels, and the same point of the other shape at its present pose.
  const Pose out{other_pose_.rotation, other_pose_.translation + shortest * along};
  answer.point_a = VoxelPair(voxels_, pose_, other_, out, options).nearest(infinity).nearest.point_a;
  answer.point_b = answer.point_a - shortest * along;
  return answer;
}

/// True if covered contacts push at a large angle to this normal: such cells have no part in its patch.
bool VoxelPair::has_covered_contact_across(const Vec3& normal) const {
  constexpr double aslant = 0.7;  // cosine
  return other_.is_bounded() && std::any_of(covered_normals_.begin(), covered_normals_.end(),
                                            [&](const Vec3& pushed) { return pushed.dot(normal) < aslant; });
}

/// Replaces the patch along the separating normal by the points at which the other shape, moved out along it, touches
/// the cells: if a capsule sinks into a floor beside an edge between two rows of cells, each row would push it into the
/// other one.
void VoxelPair::replace_patch(const PairAnswer& whole, std::vector<Contact>& out, std::size_t first) {
  std::vector<Contact> patch;
  if (other_.is_bounded()) {
    const double depth = -whole.signed_distance;
    NarrowPhaseOptions options = options_;
    options.margin += depth;
    const Pose moved{other_pose_.rotation, other_pose_.translation + depth * whole.normal};
    VoxelPair(voxels_, pose_, other_, moved, options).each_contact([&](VoxelRef cell, std::span<const Contact> list) {
      for (std::size_t k = 0; k < list.size(); ++k) {
        // From the point on the other shape, moved back, to the one on the cell.
        const Vec3 through = list[k].depth * list[k].normal + depth * whole.normal;
        const double inside = std::copysign(through.norm(), through.dot(whole.normal));
        const Vec3 normal = inside != 0 ? Vec3(through / inside) : whole.normal;
        const double along = std::min(normal.dot(whole.normal), list[k].normal.dot(whole.normal));
        if (along > one_patch && inside >= -options_.margin)
          patch.push_back(
              {list[k].point - depth / 2 * whole.normal, normal, std::min(inside, depth), feature_of_cell(cell, k)});
      }
    });
  }
  const auto begin = out.begin() + static_cast<std::ptrdiff_t>(first);
  const auto own = std::stable_partition(begin, out.end(),
                                         [&](const Contact& c) { return !(c.normal.dot(whole.normal) > one_patch); });
  patch.insert(patch.end(), own, out.end());
  out.erase(own, out.end());
  if (std::none_of(patch.begin(), patch.end(),
                   [&](const Contact& c) { return c.depth >= -whole.signed_distance - slack(); }))
    patch.push_back(contact_of(whole));
  keep_widest(patch, 0, voxels_.size() + other_.size(), &meter_);
  out.insert(out.end(), patch.begin(), patch.end());
  std::stable_sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
                   [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
}

PairAnswer VoxelPair::contacts(std::vector<Contact>& out) {
  const std::size_t first = out.size();
  PatchCollector all(voxels_.size() + other_.size(), options_);
  const CellsFound found = each_contact([&](VoxelRef cell, std::span<const Contact> list) { all.add(cell, list); });
  if (found.nearest.signed_distance == infinity) return {};
  const bool is_solid = other_.is_bounded() && other_.is_convex();
  all.finish(is_solid ? Vec3(other_pose_ * other_.mass().centre) : Vec3(Vec3::Zero()), is_solid, out);
  const bool collide = found.nearest.collide;
  if (!collide) {
    const double least = found.nearest.signed_distance;
    if (out.size() == first || from_deepest(out, first).signed_distance > least + slack())
      out.push_back(contact_of(found.nearest));
    PairAnswer answer = from_deepest(out, first);
    answer.collide = false;
    answer.status = found.nearest.status;
    answer.error_bound = found.nearest.error_bound;
    return answer;
  }
  PairAnswer answer = from_deepest(out, first);
  const auto deepest_is_free = [&] { return separates((slack() - answer.signed_distance) * answer.normal); };
  // Rounding makes cells that touch along a covered edge as deep as those that touch along a face.
  const bool has_deepest = out.size() > first && -answer.signed_distance >= found.certain - slack() &&
                           (!has_covered_contact_across(answer.normal) || (found.most <= slack() && deepest_is_free()));
  const bool is_free = has_deepest && options_.mesh_bounds && deepest_is_free();
  PairAnswer whole;
  if (!has_deepest || (options_.mesh_bounds && !is_free)) whole = depth(found);
  // In a slot exactly as wide as the other shape the contacts are those of the cells.
  const bool in_slot = found.most <= slack() && whole.error_bound > slack();
  if (!has_deepest && !in_slot) replace_patch(whole, out, first);
  if (out.size() == first) out.push_back(contact_of(found.nearest));
  answer = from_deepest(out, first);
  answer.collide = true;
  if (!options_.mesh_bounds) {
    answer.status = Status::unproven;
    return answer;
  }
  const double length = -answer.signed_distance,
               off = std::max(length - found.certain, is_free ? 0.0 : -whole.signed_distance - length);
  // A contact as deep as the separating translation need not separate by itself.
  const bool deepest_separates = has_deepest ? is_free : answer.normal.dot(whole.normal) > 1 - tolerance::alike_cosines;
  if (off > slack() || !deepest_separates) answer.status = Status::inexact, answer.error_bound = std::max(off, slack());
  return answer;
}

/// Voxels come first, of two sets of voxels the one with more cells.
bool goes_second(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  if (b.kind() != ShapeKind::voxels) return false;
  if (a.kind() != ShapeKind::voxels) return true;
  const auto p = a.cells(), q = b.cells();
  if (p.size() != q.size()) return p.size() < q.size();
  if (a.parameters() != b.parameters()) return a.parameters() < b.parameters();
  if (a.rounding() != b.rounding()) return a.rounding() < b.rounding();
  if (p.data() != q.data()) {
    const auto as_numbers = [](const VoxelCell& c) {
      return std::array<std::int64_t, 4>{c.corner[0], c.corner[1], c.corner[2], c.level};
    };
    const auto [i, j] = std::mismatch(p.begin(), p.end(), q.begin());
    if (i != p.end()) return as_numbers(*i) < as_numbers(*j);
  }
  return reversed(0, pose_a, pose_b);
}

}  // namespace

PairAnswer solve_voxels(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                        const NarrowPhaseOptions& options, std::vector<Contact>* contacts) {
  if (goes_second(a, pose_a, b, pose_b)) {
    const std::size_t begin = contacts != nullptr ? contacts->size() : 0;
    PairAnswer answer = solve_voxels(b, pose_b, a, pose_a, request, options, contacts);
    swap_answer(answer, contacts, begin);
    return answer;
  }
  // A solver named by the user is one for voxels: otherwise a cell's verdict and distance would have different solvers.
  if (!options.solver.empty()) return solve_voxels(a, pose_a, b, pose_b, request, for_triangles(options), contacts);
  // Relative to the voxels' translation: far from the origin, positions of cells would be rounded.
  const Vec3& origin = pose_a.translation;
  VoxelPair pair(a, {pose_a.rotation, Vec3::Zero()}, b, {pose_b.rotation, pose_b.translation - origin}, options);
  PairAnswer answer;
  if (request == Request::collide) {
    answer.collide = pair.collide();
    return answer;
  }
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  answer = request == Request::distance ? pair.distance() : pair.contacts(*contacts);
  if (answer.farther) return answer;
  move_answer(origin, answer, request == Request::contacts ? contacts : nullptr, first);
  return answer;
}

}  // namespace tandem
