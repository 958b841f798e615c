#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "tandem/engine/scene.h"

namespace tandem {

/// What tells whoever looks at a scene step by step what has changed in it since.
class detail::SceneChanges {
 public:
  /// One element an index: how often the body there was added, removed, given a pose, a shape or a filter, or made
  /// static or not. In a scene of the same history a body whose number is the same is where it was, and what it was.
  static std::span<const std::uint32_t> versions(const Scene& scene) { return scene.versions_; }
  /// Those changes but for poses, of all bodies so far: while the number is the same, every body has its shape and
  /// filter still.
  static std::uint64_t comings_and_goings(const Scene& scene) { return scene.comings_and_goings_; }

  /// Shapes added, removed and replaced so far.
  static std::uint64_t shape_changes(const Scene& scene) { return scene.shape_changes_; }

  /// Names a scene's past: a copy of the scene has another one. Keeping a name keeps it from being used again.
  class HistoryName {
   public:
    HistoryName() = default;
    explicit HistoryName(const Scene& scene) : mark_(scene.history_.mark()) {}
    /// Whether it is certain that both are of the same scene.
    friend bool operator==(const HistoryName& a, const HistoryName& b) {
      return a.mark_ != nullptr && a.mark_ == b.mark_;
    }

   private:
    std::shared_ptr<const char> mark_;
  };
};

using detail::SceneChanges;

}  // namespace tandem
