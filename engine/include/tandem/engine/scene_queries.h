// Queries of a scene between steps: overlaps, distances, contacts and casts of a shape, and batches of robot
// configurations.
#pragma once
#include <array>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "tandem/engine/pair_table.h"
#include "tandem/engine/scene.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/motion.h"
#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The bodies that a query tests; others are excluded before a pair is formed.
struct QueryFilter {
  std::uint32_t group = 1;  ///< bits of the groups of the query's shape
  /// Bits of the groups it collides with; as for two bodies, both directions must match.
  std::uint32_t mask = 0xffffffffu;
  std::span<const BodyId> ignore{};  ///< excluded bodies; ids of removed bodies have no effect
  /// A user's condition, called by any of the querying threads; empty: all bodies.
  std::function<bool(BodyId)> admits{};
};

/// A body, and the answer for the pair [query shape, body].
struct Hit {
  BodyId body;
  PairAnswer answer;
};

/// A body, the answer for the pair, and its contacts as a range of the list to which they were appended.
struct ContactHit {
  BodyId body;
  PairAnswer answer;
  std::size_t first = 0, count = 0;
};

/// The first contact of a moving shape with a body.
struct Impact {
  BodyId body;
  double t = 0;                                      ///< time within the motion, [0, 1]; 0: they touch at the start
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  ///< as in PairAnswer: midway, from the shape to the body
  /// The features of the shape and of the body: the triangle index of a mesh, the cell of voxels, else 0.
  std::array<std::uint32_t, 2> feature{};
};

/// The result for a configuration or a motion.
enum class Verdict : std::uint8_t {
  free,
  hit,
  unknown,  ///< the deadline passed or a stop was requested before it was decided
};

/// Poses of a batch, row by row: link j of configuration i has pose i * links + j. They are given in memory, as poses
/// or as matrices, or computed on demand, a few configurations at a time (from a robot's kinematics, or from another
/// format), which saves the time and memory for all poses at once.
class BatchPoses {
 public:
  /// Writes the poses from index `first` on. Called by any of the checking threads, for each pose at most once; an
  /// exception ends the batch and is rethrown.
  using Maker = std::function<void(std::size_t first, std::span<Pose> poses)>;

  /// Poses in memory; they must outlive the batch.
  template <std::convertible_to<std::span<const Pose>> Poses>
  BatchPoses(const Poses& poses) : lying_(poses), size_(lying_.size()) {}
  /// Poses on demand. Throws std::invalid_argument if the function is empty.
  BatchPoses(std::size_t size, Maker make) : size_(size), make_(std::move(make)) {
    if (!make_) throw std::invalid_argument("BatchPoses: make is empty, allowed: a function that writes the poses");
  }

  /// Homogeneous 4 x 4 matrices in row-major order, one after the other, as numpy's (n, 4, 4); they are read in place.
  /// Throws std::invalid_argument unless the number of values is a multiple of 16. The batch throws where a fourth row
  /// is not 0, 0, 0, 1.
  static BatchPoses of_matrices(std::span<const double> numbers) {
    if (numbers.size() % 16 != 0)
      throw std::invalid_argument("BatchPoses: " + std::to_string(numbers.size()) +
                                  " numbers, allowed: a multiple of 16, of matrices of 4 x 4");
    BatchPoses poses;
    poses.matrices_ = numbers;
    poses.size_ = numbers.size() / 16;
    return poses;
  }

  std::size_t size() const { return size_; }
  std::span<const Pose> lying() const { return lying_; }          ///< empty for matrices and for poses on demand
  std::span<const double> matrices() const { return matrices_; }  ///< the values of matrices; otherwise empty
  const Maker& make() const { return make_; }                     ///< empty unless poses are computed on demand

 private:
  BatchPoses() = default;
  std::span<const Pose> lying_;
  std::span<const double> matrices_;
  std::size_t size_ = 0;
  Maker make_;
};

/// Options of batches of configurations.
struct BatchOptions {
  double margin = 0;                 ///< metres, finite, >= 0: gaps up to this count as hits
  QueryFilter filter{};              ///< for all links
  /// Links x body indices: the pairs that are tested; null: all that the filter admits.
  const PairTable* world = nullptr;
  /// The number of consecutive configurations that form a motion with a single verdict: is all of it free? They are
  /// tested in the order that finds a hit soonest. The number of configurations is a multiple of it; >= 1.
  std::size_t configurations_a_motion = 1;
  /// The motion between configurations is tested, too: every link moves from one to the next on a screw (Motion), and
  /// `free` is certified, not sampled. A gap below 1e-10 of the path may be reported as a hit. `check` only.
  bool continuous = false;
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::stop_token stop{};  ///< has the effect of the deadline, also within pairs with a mesh
  /// Number of finished verdicts; called by any thread, from time to time.
  std::function<void(std::size_t done, std::size_t all)> progress{};
};

/// The first hit of a configuration or motion: in the first configuration that hits, the first pair of links [link,
/// other_link], else the first link and the body of least index that it hits.
struct FirstHit {
  Verdict verdict = Verdict::unknown;
  std::uint32_t configuration = 0;  ///< index within the motion; this and all below: only where the verdict is `hit`
  std::uint32_t link = 0;
  std::uint32_t other_link = 0;  ///< if `body` is none
  BodyId body{};
};

/// The effect of an update.
struct UpdateReport {
  std::size_t changed = 0;  ///< number of bodies that were added, removed or moved
  bool rebuilt = false;     ///< the hierarchy was rebuilt, not refitted
  double ms = 0;            ///< wall time
};

/// Queries of a scene: the bodies that a shape touches, the nearest one, the first one on a shape's path, and the same
/// for many configurations of a robot at once. Queries use a copy of the scene as of the last update; the scene itself
/// may change meanwhile.
///
/// Const calls are safe from any number of threads at once and give the same bits on any number; each runs on the
/// calling thread, except `check`, `first_hits` and `clearance`, which use the oneTBB arena in which they are called.
/// Tests use the exact shapes, not their boxes. An invalid pose, a margin or cut-off that is negative or NaN, and pairs
/// that NarrowPhase refuses throw std::invalid_argument, which names them.
class SceneQueries {
 public:
  /// `options`: tolerance, solver and limit of all queries; its margin and cut-off are ignored. When the limit is
  /// reached, `check`, `first_hits` and `clearance` report undecided results as such; all other queries throw
  /// WorkStopped.
  explicit SceneQueries(const Scene& scene, const NarrowPhaseOptions& options = {});
  ~SceneQueries();
  SceneQueries(SceneQueries&&) noexcept;
  SceneQueries& operator=(SceneQueries&&) noexcept;

  /// Copies the changes of the scene, or another scene. Cost with k moved bodies: a pass over all bodies' versions and
  /// a refit, k log n; with bodies at new indices, or another scene: n log n. Builds new meshes' lazy data (prepare.h),
  /// so that no query waits for it; the owner of a query's own mesh may do the same. If it throws (out of memory),
  /// queries throw std::logic_error until an update succeeds.
  UpdateReport update(const Scene& scene);
  std::size_t memory() const;  ///< bytes, without shapes

  /// Whether any body is at most `margin` away. Ends at the first.
  bool collides(const Shape& shape, const Pose& pose, double margin = 0, const QueryFilter& filter = {}) const;
  /// Appends the bodies that touch the shape, by index.
  void hits(const Shape& shape, const Pose& pose, std::vector<BodyId>& bodies, const QueryFilter& filter = {}) const;
  /// The body with the least signed distance, if that is at most `cutoff`; of several the one of least index.
  std::optional<Hit> nearest(const Shape& shape, const Pose& pose,
                             double cutoff = std::numeric_limits<double>::infinity(),
                             const QueryFilter& filter = {}) const;
  /// Appends the bodies with a signed distance of at most `margin`, by index.
  void within(const Shape& shape, const Pose& pose, double margin, std::vector<Hit>& hits,
              const QueryFilter& filter = {}) const;
  /// Appends the bodies with contacts, including gaps up to `margin`, by index, and the contacts.
  void contacts(const Shape& shape, const Pose& pose, double margin, std::vector<ContactHit>& hits,
                std::vector<Contact>& contacts, const QueryFilter& filter = {}) const;
  /// The first body that the moving shape touches, of several the one of least index; a sphere of radius 0 is a ray.
  std::optional<Impact> cast(const Shape& shape, const Motion& motion, const QueryFilter& filter = {}) const;

  /// The same queries for a body of the scene at its pose, with its groups and mask; they exclude the body itself and,
  /// if it is static, all static bodies. Throw std::invalid_argument unless the id is that of a body of the last
  /// update.
  bool collides(BodyId body, double margin = 0) const;
  void hits(BodyId body, std::vector<BodyId>& bodies) const;
  std::optional<Hit> nearest(BodyId body, double cutoff = std::numeric_limits<double>::infinity()) const;
  void within(BodyId body, double margin, std::vector<Hit>& hits) const;

  /// Checks configurations of links. Verdict i is `hit` if a link touches a body, or another link (pairs i < j in
  /// `self`). Throws std::invalid_argument unless the sizes match; links must be bounded.
  void check(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self, std::span<Verdict> verdicts,
             const BatchOptions& options = {}) const;
  /// Computes the first hit of each configuration; not continuous. Slower than `check`, as the order of tests is fixed.
  void first_hits(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                  std::span<FirstHit> hits, const BatchOptions& options = {}) const;
  /// Computes the least signed distance of each configuration, between any of its links and the bodies or one another:
  /// `cutoff` if it is not less, minus infinity if the deadline passed or a stop was requested first.
  void clearance(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                 std::span<double> distances, double cutoff = std::numeric_limits<double>::infinity(),
                 const BatchOptions& options = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
