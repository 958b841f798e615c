// The boxes of a scene's bodies, in which the broad phase finds pairs.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pipeline/kept_contacts.h"
#include "pipeline/outward_boxes.h"
#include "scene/scene_changes.h"
#include "tandem/broadphase/box_array.h"
#include "tandem/engine/scene.h"
#include "tandem/narrowphase/several_pairs.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// The boxes of a scene's bodies, grown by half the margin on each side: two boxes overlap if the gap between their
/// bodies is within the margin. In each step only those of bodies that changed are computed, in independent blocks.
class BodyBoxes {
 public:
  /// `kept`: boxes contain resting bodies wherever they may be while they rest; null: no answers are kept.
  /// `with_spheres`: spheres() are stored.
  BodyBoxes(double margin, KeptContacts* kept, bool with_spheres)
      : margin_(margin), kept_(kept), with_spheres_(with_spheres) {}

  /// Begins a step, before its blocks. The scene and the limit must outlive it.
  void begin_step(const Scene& scene, const WorkLimit& limit);
  /// Notes that the step was complete: the next one may rely on its boxes.
  void end_step() { is_complete_ = true; }
  /// Discards what earlier steps recorded.
  void begin_anew() { is_complete_ = false; }

  std::size_t blocks() const { return (boxes_.size() + bodies_a_block - 1) / bodies_a_block; }
  /// Computes the boxes of a block's bodies that changed. Throws WorkStopped where the limit ended the building of a
  /// mesh's hull; then the next query builds it.
  void update(std::size_t block);

  /// True if the scene records all changes since the last complete step: changed() is known.
  bool changes_known() const { return changes_known_; }
  const BoxArray& boxes() const { return boxes_; }
  std::span<const std::uint8_t> changed() const { return changed_; }  ///< one a box: whether it changed in this step
  /// One a body, if answers are kept: bit 0 for a static one, bit 1 for one whose box has not changed.
  std::span<const std::uint8_t> still() const { return still_; }
  /// One a body, with an infinite radius if it is another shape.
  std::span<const PlacedSphere> spheres() const { return spheres_; }
  std::size_t memory() const;  ///< bytes

 private:
  static constexpr std::size_t bodies_a_block = 4 * BoundsRows::bodies;

  void update(std::size_t first, std::size_t end);
  bool find_changed(std::size_t first, std::size_t end);
  void take_bounds(std::uint32_t body, std::size_t k, BoundsRows& rows);
  void store(const BoundsRows& rows, std::span<const std::uint32_t> bodies, bool in_row);

  double margin_;
  KeptContacts* kept_;
  bool with_spheres_;
  const Scene* scene_ = nullptr;
  const WorkLimit* limit_ = nullptr;
  BoxArray boxes_;
  std::vector<std::uint8_t> changed_, still_;
  std::vector<PlacedSphere> spheres_;
  // The data that the last complete step read; whether changes since then are known.
  bool is_complete_ = false, changes_known_ = false, shapes_known_ = false;
  SceneChanges::HistoryName history_;
  std::uint64_t comings_and_goings_ = 0;
  std::vector<std::uint32_t> seen_;  // versions
};

/// True if the body is a sphere.
inline bool is_sphere(const PlacedSphere& placed) { return placed.radius <= std::numeric_limits<double>::max(); }

}  // namespace tandem
