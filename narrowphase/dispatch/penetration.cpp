// The depth of two shapes: the result of a distance query, a search for shorter translations, and a cover of all that
// are shorter still.
#include "tandem/narrowphase/penetration.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "meshes/depth/overlap_cover.h"
#include "meshes/depth/overlapping_meshes.h"
#include "meshes/depth/shared_places.h"
#include "meshes/mesh_pair.h"
#include "shapes/hull.h"
#include "shapes/posed_mesh.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "shapes/written.h"
#include "tandem/narrowphase/clearance.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"
#include "tolerances.h"

namespace tandem {
namespace {

// The shortest known translation of B, relative to A, after which the two do not collide.
class ShortestFree {
 public:
  ShortestFree(const Posed& a, const Posed& b, const NarrowPhaseOptions& options)
      : a_(a), b_(b), options_(options), narrow_(options), size_(a.shape.size() + b.shape.size()) {}

  bool found() const { return best_.has_value(); }
  double length() const { return best_ ? best_->norm() : infinity; }
  const Vec3& translation() const { return *best_; }
  Pose moved(const Vec3& move) const { return {b_.pose.rotation, b_.pose.translation + move}; }

  bool is_free(const Vec3& move) const {
    const Pose at = moved(move);
    return !unless_stopped(narrow_.solve(a_.shape, a_.pose, b_.shape, at, Request::collide)).collide;
  }

  /// The first free translation along a direction (unit) that is longer than `length` by the rounding of positions, or
  /// by four times that, and so on; where it ends at the other side of a notch, also a little away from that.
  Vec3 farther(const Vec3& direction, double length) const {
    constexpr int most = 64;
    // Of points in one place every other number is zero.
    const double scale =
        std::max(size_ + a_.pose.translation.norm() + b_.pose.translation.norm() + length, tolerance::shortest_length);
    double more = tolerance::translation_slack * scale;
    for (int i = 0; i < most; ++i, more *= 4) {
      const Vec3 end = (length + more) * direction;
      if (is_free(end)) return end;
      if (const Vec3 aside = off_side(end, more); is_free(aside)) return aside;
    }
    throw std::logic_error("penetration_depth: no translation along a direction separates");
  }

  void take(const Vec3& free) {
    if (free.norm() < length()) best_ = free;
  }

  /// The last contact along a direction (unit).
  Vec3 along(const Vec3& direction) const {
    return farther(direction, separation_along(a_.shape, a_.pose, b_.shape, b_.pose, direction, options_));
  }

  /// From a free translation of two meshes: back to contact, around the obstacle, back again.
  void shorten(Vec3 free) {
    constexpr int rounds = 8;
    for (int i = 0; i < rounds; ++i) {
      const double before = free.norm();
      free = pulled_in(free);
      OverlappingMeshes overlap(a_, b_, {}, options_);
      SeparationSearch search(overlap, {.length = free.norm(), .normal = unit(free)});
      search.shorten();
      if (const Vec3 to = search.known.length * search.known.normal; to.norm() < free.norm() && is_free(to)) free = to;
      take(free);
      if (!(free.norm() < tolerance::worth_shortening * before)) return;
    }
  }

 private:
  // A translation after which they overlap by a little, and off that.
  Vec3 off_side(const Vec3& end, double little) const {
    const PairAnswer side = unless_stopped(narrow_.solve(a_.shape, a_.pose, b_.shape, moved(end), Request::distance));
    return end + std::clamp(little - side.signed_distance, 0.0, 4 * little) * side.normal;
  }

  Vec3 pulled_in(const Vec3& free) const {
    const double length = free.norm();
    const Pose from = moved(free);
    const auto touch = narrow_.time_of_impact(a_.shape, a_.pose, Vec3::Zero(), b_.shape, from, -free, 1.0);
    if (!touch) return free;
    const double to = (1 - *touch) * length + 8 * tolerance::place_rounding * size_;
    return to < length && is_free(to / length * free) ? Vec3(to / length * free) : free;
  }

  const Posed a_, b_;
  const NarrowPhaseOptions& options_;
  const NarrowPhase narrow_;
  const double size_;
  std::optional<Vec3> best_;
};

// Directions to the corners, edges and faces of a cube.
std::vector<Vec3> directions_all_round() {
  std::vector<Vec3> all;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0) all.push_back(Vec3(x, y, z).normalized());
  return all;
}

// Tries the few shortest of the distance query's result and the last contacts in directions all around, and shortens
// them.
void search_free(const PairAnswer& known, ShortestFree& free) {
  constexpr std::size_t most = 6;
  std::vector<Vec3> starts{free.farther(known.normal, -known.signed_distance)};
  free.take(starts.front());
  for (const Vec3& direction : directions_all_round()) starts.push_back(free.along(direction));
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Vec3& x, const Vec3& y) { return x.squaredNorm() < y.squaredNorm(); });
  starts.resize(std::min(most, starts.size()));
  for (const Vec3& start : starts)
    if (free.is_free(start)) free.shorten(start);
}

// For two meshes, one of them solid, that collide; A's translation is zero. If a limit ends it, the bounds reached are
// returned.
DepthBounds search_bounds(const Posed& a, const Posed& b, const PairAnswer& known, const DepthOptions& options) {
  NarrowPhaseOptions narrow_options;
  narrow_options.limit = options.limit;
  DepthBounds bounds;
  bounds.lower = -known.signed_distance - known.error_bound;
  ShortestFree free(a, b, narrow_options);
  std::optional<DepthField> field_a, field_b;
  std::optional<OverlapCover> cover;
  try {
    search_free(known, free);
    const double part = 1 - options.gap,
                 slack = tolerance::place_rounding * (reach(mesh_of(a.shape)) + reach(mesh_of(b.shape)));
    if (bounds.lower < part * free.length()) {
      constexpr std::size_t most_places = 8;
      field_a.emplace(a, slack, options.limit), field_b.emplace(b, slack, options.limit);
      cover.emplace(*field_a, *field_b, free.length(),
                    OverlapCover::Bodies{.shared_places =
                                             [&](const Vec3& move) {
                                               const Pose at = free.moved(move);
                                               return shared_places(a, {b.shape, at}, most_places, options.limit);
                                             },
                                         .shorten =
                                             [&](const Vec3& move) {
                                               free.shorten(move);
                                               return free.length();
                                             }});
      cover->search(part, options.most_boxes);
    }
  } catch (const WorkStopped&) {
    bounds.incomplete = true;
  }
  if (cover) {
    bounds.lower = std::max(bounds.lower, cover->certain());
    bounds.boxes = cover->boxes();
  }
  bounds.translation = free.found() ? free.translation() : Vec3(-known.signed_distance * known.normal);
  return bounds;
}

// The shape itself, or a mesh of the same polytope; empty for other shapes.
std::optional<Shape> as_mesh(const Shape& shape) {
  if (shape.rounding() > 0) return std::nullopt;
  if (shape.kind() == ShapeKind::mesh) return shape;
  Mesh mesh;
  mesh.solid = true;
  if (shape.kind() == ShapeKind::box) {
    const Vec3 h = shape.half_size();
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k)
      corners.emplace_back(k & 1 ? h.x() : -h.x(), k & 2 ? h.y() : -h.y(), k & 4 ? h.z() : -h.z());
    return as_mesh(Shape(Convex{corners}));
  }
  if (shape.kind() != ShapeKind::convex || hull_of(shape).dimension != 3) return std::nullopt;
  const Hull& hull = hull_of(shape);
  mesh.vertices = hull.vertices;
  for (const Hull::Face& face : hull.faces)
    for (std::uint32_t k = face.first + 1; k + 1 < face.first + face.count; ++k)
      mesh.triangles.push_back({hull.loop[face.first], hull.loop[k], hull.loop[k + 1]});
  return Shape(std::move(mesh));
}

std::optional<DepthBounds> searched(const Posed& a, const Posed& b, const PairAnswer& known,
                                    const DepthOptions& options) {
  if (known.status == Status::ok || options.most_boxes == 0) return std::nullopt;
  const std::optional<Shape> mesh_a = as_mesh(a.shape), mesh_b = as_mesh(b.shape);
  if (!mesh_a || !mesh_b || !(mesh_a->is_solid() || mesh_b->is_solid())) return std::nullopt;
  // Relative to A's translation: far from the origin, positions would be rounded.
  const Pose at_a{a.pose.rotation, Vec3::Zero()}, at_b{b.pose.rotation, b.pose.translation - a.pose.translation};
  const Posed posed_a{*mesh_a, at_a}, posed_b{*mesh_b, at_b};
  if (goes_first(posed_a, posed_b)) return search_bounds(posed_a, posed_b, known, options);
  const Pose back_b{b.pose.rotation, Vec3::Zero()}, back_a{a.pose.rotation, -at_b.translation};
  PairAnswer exchanged = known;
  exchanged.normal = -known.normal;
  DepthBounds bounds = search_bounds({*mesh_b, back_b}, {*mesh_a, back_a}, exchanged, options);
  bounds.translation = -bounds.translation;
  return bounds;
}

}  // namespace

DepthBounds penetration_depth(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                              const DepthOptions& options) {
  if (!(options.gap >= 0 && options.gap <= 1))
    throw std::invalid_argument("penetration_depth: gap " + written(options.gap) + " is not in [0, 1]");
  require_valid(pose_a, "penetration_depth: pose of A");
  require_valid(pose_b, "penetration_depth: pose of B");
  NarrowPhaseOptions narrow_options;
  narrow_options.limit = options.limit;
  const NarrowPhase narrow(narrow_options);
  if (const std::string why = narrow.refuses(a, b, Request::distance); !why.empty()) throw std::invalid_argument(why);
  const PairAnswer known = unless_stopped(narrow.solve(a, pose_a, b, pose_b, Request::distance));
  DepthBounds bounds;
  if (!known.collide) return bounds;
  const Posed posed_a{a, pose_a}, posed_b{b, pose_b};
  if (const auto found = searched(posed_a, posed_b, known, options)) {
    bounds = *found;
  } else {
    bounds.lower = -known.signed_distance - known.error_bound;
    bounds.translation = -known.signed_distance * known.normal;
  }
  bounds.collide = true;
  // In the world, B's position is rounded.
  const double length = bounds.translation.norm();
  const Vec3 out = length > 0 ? unit(bounds.translation, length) : known.normal;
  const NarrowPhaseOptions to_the_end;
  const ShortestFree free(posed_a, posed_b, to_the_end);
  if (!free.is_free(bounds.translation)) bounds.translation = free.farther(out, length);
  bounds.upper = bounds.translation.norm();
  bounds.lower = std::clamp(bounds.lower, 0.0, bounds.upper);
  return bounds;
}

}  // namespace tandem
