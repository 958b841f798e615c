// Updates the copy of a scene's bodies and the hierarchy of their boxes.
#include "queries/query_world.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "scene/swept_boxes.h"
#include "scene/tolerances.h"
#include "tandem/narrowphase/prepare.h"

namespace tandem {

Aabb outward_box(const Shape& shape, const Pose& pose, double margin, const WorkLimit* limit) {
  const Bounds bounds = shape.bounds(pose, limit);
  Aabb box;
  for (int k = 0; k < 3; ++k) {
    box.lo[static_cast<std::size_t>(k)] = round_down(bounds.lo[k] - margin);
    box.hi[static_cast<std::size_t>(k)] = round_up(bounds.hi[k] + margin);
  }
  return box;
}

bool QueryWorld::admits(const QueryFilter& filter, std::uint32_t index) const {
  if ((groups_[index] & filter.mask) == 0 || (filter.group & masks_[index]) == 0) return false;
  const BodyId body = ids_[index];
  if (std::find(filter.ignore.begin(), filter.ignore.end(), body) != filter.ignore.end()) return false;
  return !filter.admits || filter.admits(body);
}

void QueryWorld::set_box(std::uint32_t index) {
  if (ids_[index] == BodyId{} || !shape(index).is_bounded())
    boxes_.set_empty(index);
  else
    boxes_.set(index, outward_box(shape(index), poses_[index], touch_share(shape(index)), nullptr));
}

void QueryWorld::set_own_box(std::uint32_t index) {
  if (ids_[index] != BodyId{} && shape(index).is_bounded()) own_boxes_[index] = LinkBox(shape(index));
}

void QueryWorld::copy_shapes(const Scene& scene) {
  shapes_.assign(scene.shapes().begin(), scene.shapes().end());
  tbb::parallel_for(std::size_t{0}, shapes_.size(), [&](std::size_t i) { prepare(shapes_[i]); });
  shape_changes_ = SceneChanges::shape_changes(scene);
}

void QueryWorld::copy_all(const Scene& scene) {
  const std::size_t size = scene.indices();
  copy_shapes(scene);
  shape_.assign(scene.shape_indices().begin(), scene.shape_indices().end());
  poses_.assign(scene.poses().begin(), scene.poses().end());
  groups_.assign(scene.groups().begin(), scene.groups().end());
  masks_.assign(scene.masks().begin(), scene.masks().end());
  static_.assign(scene.is_static().begin(), scene.is_static().end());
  const auto versions = SceneChanges::versions(scene);
  versions_.assign(versions.begin(), versions.end());
  ids_.resize(size);
  boxes_.resize(size);
  own_boxes_.resize(size);
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(size), 1024),
                    [&](const auto& block) {
                      for (std::uint32_t i = block.begin(); i != block.end(); ++i) {
                        ids_[i] = scene.alive(i) ? scene.id(i) : BodyId{};
                        set_box(i);
                        set_own_box(i);
                      }
                    });
}

void QueryWorld::build() {
  tree_.build(boxes_, [](std::size_t blocks, const auto& block) { tbb::parallel_for(std::size_t{0}, blocks, block); });
  bits_.build(boxes_);
  placed_.resize(ids_.size());
  unbounded_.clear();
  for (std::uint32_t i = 0; i < ids_.size(); ++i) {
    placed_[i] = ids_[i] != BodyId{} && shape(i).is_bounded();
    if (ids_[i] != BodyId{} && !placed_[i]) unbounded_.push_back(i);
  }
}

// Returns false if a changed body is not in the hierarchy.
bool QueryWorld::copy_changed(const Scene& scene) {
  const bool other_shapes = SceneChanges::shape_changes(scene) != shape_changes_;
  if (other_shapes) copy_shapes(scene);
  bool have_places = true;
  for (const std::uint32_t i : changed_) {
    const bool bounded_before = placed_[i] != 0;
    const std::uint32_t old_shape = std::exchange(shape_[i], scene.shape_indices()[i]);
    poses_[i] = scene.poses()[i];
    groups_[i] = scene.groups()[i];
    masks_[i] = scene.masks()[i];
    static_[i] = scene.is_static()[i];
    const bool was_unbounded = ids_[i] != BodyId{} && !bounded_before;
    const BodyId old_id = std::exchange(ids_[i], scene.alive(i) ? scene.id(i) : BodyId{});
    set_box(i);
    if (other_shapes || old_shape != shape_[i] || old_id != ids_[i]) set_own_box(i);
    const bool is_unbounded = ids_[i] != BodyId{} && !shape(i).is_bounded();
    have_places = have_places && bounded_before && !was_unbounded && !is_unbounded;
  }
  return have_places;
}

UpdateReport QueryWorld::update(const Scene& scene) {
  const auto start = std::chrono::steady_clock::now();
  UpdateReport report;
  const auto versions = SceneChanges::versions(scene);
  // The version is unknown until the update is complete: after an exception the next one copies all.
  SceneChanges::HistoryName history = std::exchange(history_, {});
  if (!(history == SceneChanges::HistoryName(scene)) || ids_.size() != scene.indices()) {
    copy_all(scene);
    build();
    history = SceneChanges::HistoryName(scene);
    report.changed = ids_.size();
    report.rebuilt = true;
  } else {
    changed_.clear();
    for (std::uint32_t i = 0; i < versions.size(); ++i)
      if (versions[i] != versions_[i]) changed_.push_back(i);
    for (const std::uint32_t i : changed_) versions_[i] = versions[i];
    report.changed = changed_.size();
    if (!copy_changed(scene)) {
      build();
      report.rebuilt = true;
    } else if (!changed_.empty()) {
      tree_.refit(boxes_, changed_);
      for (const std::uint32_t i : changed_) bits_.move(i, boxes_[i]);
      if (tree_.worn() > tolerance::worn_hierarchy) {
        build();
        report.rebuilt = true;
      }
    }
  }
  history_ = std::move(history);
  report.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return report;
}

std::size_t QueryWorld::memory() const {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(*list.data()); };
  return bytes(shapes_) + bytes(shape_) + bytes(groups_) + bytes(masks_) + bytes(versions_) + bytes(unbounded_) +
         bytes(poses_) + bytes(own_boxes_) + bytes(ids_) + bytes(static_) + bytes(placed_) + bytes(changed_) +
         boxes_.memory() + tree_.memory() + bits_.memory();
}

}  // namespace tandem
