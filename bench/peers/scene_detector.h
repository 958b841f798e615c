#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tandem/engine/scene.h"

namespace tandem::bench {

/// What a contestant found in a step, in its own words: bodies that touch and what it holds of each contact.
struct TouchingPair {
  std::uint32_t a, b;  ///< body indices, a < b
  std::uint32_t contacts;
  double depth;  ///< of the deepest
};

/// A library set up for a scene as a careful user would: shapes built once, bodies kept from step to step.
class SceneDetector {
 public:
  virtual ~SceneDetector() = default;
  virtual std::string name() const = 0;
  virtual int threads() const { return 1; }
  /// Takes the poses of the bodies that move and computes all contacts. This is what is timed.
  virtual void detect(const Scene& scene) = 0;
  /// Of the last step: pairs whose answer was kept from an earlier one, where a contestant tells.
  virtual double kept_pairs() const { return 0; }
  /// Of the last step, each pair once, in any order. Not timed.
  virtual std::vector<TouchingPair> found() const = 0;
  /// Of the last step's ContactList (`hash`), where a contestant has one; else 0.
  virtual std::uint64_t list_hash() const { return 0; }
};

using SceneDetectors = std::vector<std::unique_ptr<SceneDetector>>;

// Each looks at the scene's shapes and bodies, which stay as they are but for their poses. The scene outlives them.

/// Everything computed, on each number of threads (one: sequential, else flowgraph); then with contacts kept that are
/// right to a thousandth of the bodies' size.
SceneDetectors tandem_detectors(const std::vector<int>& threads);
/// DynamicAABBTreeCollisionManager in double precision. With meshes twice: four contacts a pair, and all.
SceneDetectors fcl_detectors(const Scene& scene);
/// btCollisionWorld with dbvt and persistent manifolds.
SceneDetectors bullet_detectors(const Scene& scene);

}  // namespace tandem::bench
