// The interface of a library in the bench of whole steps.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tandem/engine/scene.h"

namespace tandem::bench {

/// A result of a step in any library's terms: two bodies that touch, and the number and depth of their contacts.
struct TouchingPair {
  std::uint32_t a, b;  ///< body indices, a < b
  std::uint32_t contacts;
  double depth;  ///< of the deepest contact
};

/// A library set up for a scene as a careful user would do it: shapes built once, bodies kept from step to step.
class SceneDetector {
 public:
  virtual ~SceneDetector() = default;
  virtual std::string name() const = 0;
  virtual int threads() const { return 1; }
  /// Takes the poses of the moving bodies and computes all contacts; this is timed.
  virtual void detect(const Scene& scene) = 0;
  /// For the last step: the number of pairs whose answer was kept from an earlier one, if the contestant reports it.
  virtual double kept_pairs() const { return 0; }
  /// For the last step: the touching pairs, each once, in any order. Not timed.
  virtual std::vector<TouchingPair> found() const = 0;
  /// For the last step: the hash of the ContactList, if the contestant has one; else 0.
  virtual std::uint64_t list_hash() const { return 0; }
};

using SceneDetectors = std::vector<std::unique_ptr<SceneDetector>>;

// Detectors of a scene, whose shapes and bodies must not change but for the poses. The scene outlives them.

/// tandem: all contacts computed, on each number of threads (one: sequential, else flowgraph); then with kept contacts
/// that are right to a thousandth of the bodies' size.
SceneDetectors tandem_detectors(const std::vector<int>& threads);
/// FCL's DynamicAABBTreeCollisionManager in double precision. With meshes twice: four contacts a pair, and all
/// contacts.
SceneDetectors fcl_detectors(const Scene& scene);
/// Bullet's btCollisionWorld with dbvt and persistent manifolds.
SceneDetectors bullet_detectors(const Scene& scene);

}  // namespace tandem::bench
