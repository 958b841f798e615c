// The changes of a scene since an earlier step.
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "tandem/engine/scene.h"

namespace tandem {

/// Counters by which an observer of a scene finds what has changed since an earlier step.
class detail::SceneChanges {
 public:
  /// One element an index: how often the body there was added, removed, given a pose, a shape or a filter, or made
  /// static or not. In a scene of the same history a body with the same number is unchanged.
  static std::span<const std::uint32_t> versions(const Scene& scene) { return scene.versions_; }
  /// The number of such changes other than poses, over all bodies: while it is the same, every body still has its shape
  /// and filter.
  static std::uint64_t comings_and_goings(const Scene& scene) { return scene.comings_and_goings_; }

  /// Shapes added, removed and replaced so far.
  static std::uint64_t shape_changes(const Scene& scene) { return scene.shape_changes_; }

  /// Identifies a scene's history: a copy of the scene has another one. While a name is held it is not reused.
  class HistoryName {
   public:
    HistoryName() = default;
    explicit HistoryName(const Scene& scene) : mark_(scene.history_.mark()) {}
    /// True if both are certainly of the same scene.
    friend bool operator==(const HistoryName& a, const HistoryName& b) {
      return a.mark_ != nullptr && a.mark_ == b.mark_;
    }

   private:
    std::shared_ptr<const char> mark_;
  };

  /// Names the shapes of a scene in their state of that time.
  class ShapesName {
   public:
    ShapesName() = default;
    explicit ShapesName(const Scene& scene) : history_(scene), changes_(shape_changes(scene)) {}
    /// True if the shapes are certainly the same.
    friend bool operator==(const ShapesName& a, const ShapesName& b) {
      return a.history_ == b.history_ && a.changes_ == b.changes_;
    }

   private:
    HistoryName history_;
    std::uint64_t changes_ = 0;
  };
};

using detail::SceneChanges;

}  // namespace tandem
