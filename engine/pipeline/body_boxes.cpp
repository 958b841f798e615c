// Computes the boxes of the bodies that changed.
#include "pipeline/body_boxes.h"

#include <algorithm>
#include <array>
#include <limits>

namespace tandem {
namespace {

double sphere_radius(const Shape& shape) {
  return shape.kind() == ShapeKind::sphere ? shape.radius() : std::numeric_limits<double>::infinity();
}

}  // namespace

void BodyBoxes::begin_step(const Scene& scene, const WorkLimit& limit) {
  scene_ = &scene;
  limit_ = &limit;
  // Data that the last complete step read from the same scene is still valid where the scene records no change.
  const SceneChanges::HistoryName history(scene);
  const std::uint64_t comings_and_goings = SceneChanges::comings_and_goings(scene);
  const bool same = is_complete_ && history == history_ && boxes_.size() == scene.indices();
  shapes_known_ = same && comings_and_goings == comings_and_goings_;
  changes_known_ = same && (kept_ == nullptr || comings_and_goings == comings_and_goings_);
  comings_and_goings_ = comings_and_goings;
  history_ = history;
  is_complete_ = false;
  boxes_.resize(scene.indices());
  changed_.resize(scene.indices());
  seen_.resize(scene.indices());
  if (kept_ != nullptr) still_.resize(scene.indices());
  if (with_spheres_) spheres_.resize(scene.indices());
}

void BodyBoxes::update(std::size_t block) {
  const std::size_t first = block * bodies_a_block, end = std::min(boxes_.size(), first + bodies_a_block);
  for (std::size_t i = first; i < end; i += BoundsRows::bodies) update(i, std::min(end, i + BoundsRows::bodies));
}

void BodyBoxes::update(std::size_t first, std::size_t end) {
  if (!find_changed(first, end)) return;
  std::array<std::uint32_t, BoundsRows::bodies> todo;
  std::size_t count = 0;
  for (std::size_t i = first; i < end; ++i) {
    todo[count] = static_cast<std::uint32_t>(i);
    count += changed_[i];
  }
  BoundsRows rows;
  for (std::size_t k = 0; k < count; ++k) take_bounds(todo[k], k, rows);
  // Elements past the end are rounded with the others, so they must be initialised.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::fill(rows.lo[axis] + count, rows.lo[axis] + BoundsRows::bodies, 0.0);
    std::fill(rows.hi[axis] + count, rows.hi[axis] + BoundsRows::bodies, 0.0);
  }
  store(rows, {todo.data(), count}, count == end - first);
}

/// Records which bodies' versions changed, also for the broad phase. Returns whether any did.
bool BodyBoxes::find_changed(std::size_t first, std::size_t end) {
  const auto versions = SceneChanges::versions(*scene_);
  const auto is_static = scene_->is_static();
  // Local pointers: to the compiler, a written byte might alias any member.
  std::uint8_t *const changed = changed_.data(), *const still = still_.data();
  std::uint32_t* const seen = seen_.data();
  const std::uint8_t all_changed = changes_known_ ? 0 : 1;
  for (std::size_t i = first; i < end; ++i) {
    changed[i] = versions[i] != seen[i] ? 1 : all_changed;
    seen[i] = versions[i];
  }
  if (kept_ != nullptr) {
    kept_->update_rests(first, std::span(changed_).subspan(first, end - first));  // boxes contain resting bodies
    for (std::size_t i = first; i < end; ++i) still[i] = static_cast<std::uint8_t>(is_static[i] | (2 - 2 * changed[i]));
  }
  std::uint8_t any = 0;
  for (std::size_t i = first; i < end; ++i) any |= changed[i];
  return any != 0;
}

/// Writes a body's bounds to column k, and its sphere.
void BodyBoxes::take_bounds(std::uint32_t body, std::size_t k, BoundsRows& rows) {
  const auto poses = scene_->poses();
  if (with_spheres_) {
    const double radius = shapes_known_ ? spheres_[body].radius : sphere_radius(scene_->shape_of(body));
    spheres_[body] = {poses[body].translation, radius};
    if (is_sphere(spheres_[body])) {  // as Shape::bounds, whose data is elsewhere in memory
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double centre = spheres_[body].centre[static_cast<Eigen::Index>(axis)];
        rows.lo[axis][k] = centre - radius;
        rows.hi[axis][k] = centre + radius;
      }
      return;
    }
  }
  const Shape& shape = scene_->shape_of(body);
  const Bounds bounds =
      kept_ != nullptr ? shape.bounds(kept_->anchor(body), limit_) : shape.bounds(poses[body], limit_);
  const double reach = kept_ != nullptr ? kept_->reach(body) : 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rows.lo[axis][k] = bounds.lo[static_cast<Eigen::Index>(axis)] - reach;
    rows.hi[axis][k] = bounds.hi[static_cast<Eigen::Index>(axis)] + reach;
  }
}

/// Writes bounds of bodies, consecutive ones if `in_row`, rounded outwards, to the boxes.
void BodyBoxes::store(const BoundsRows& rows, std::span<const std::uint32_t> bodies, bool in_row) {
  FloatRows rounded;
  round_outward(rows, 0.5 * margin_, rounded);
  for (int axis = 0; axis < 3; ++axis) {
    float *const lo = boxes_.lo(axis), *const hi = boxes_.hi(axis);
    if (in_row) {
      std::copy_n(rounded.lo[axis], bodies.size(), lo + bodies[0]);
      std::copy_n(rounded.hi[axis], bodies.size(), hi + bodies[0]);
      continue;
    }
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      lo[bodies[k]] = rounded.lo[axis][k];
      hi[bodies[k]] = rounded.hi[axis][k];
    }
  }
  for (const std::uint32_t body : bodies)
    if (!scene_->alive(body)) boxes_.set_empty(body);
}

std::size_t BodyBoxes::memory() const {
  const auto bytes = [](const auto&... list) { return (std::size_t{0} + ... + (list.capacity() * sizeof(list[0]))); };
  return boxes_.memory() + bytes(still_, changed_, seen_, spheres_);
}

}  // namespace tandem
