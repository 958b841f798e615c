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

/// Which bodies a query is for; all others are left out before a pair exists.
struct QueryFilter {
  std::uint32_t group = 1;               ///< bits of the groups that the asking shape is in
  std::uint32_t mask = 0xffffffffu;      ///< bits of the groups it meets; as of two bodies, both directions are needed
  std::span<const BodyId> ignore{};      ///< bodies that are left out; ids of removed bodies name none
  std::function<bool(BodyId)> admits{};  ///< a rule of one's own, from any of the threads that ask; empty: all bodies
};

/// A body and the answer of the pair [the asking shape, the body].
struct Hit {
  BodyId body;
  PairAnswer answer;
};

/// A body, the answer of the pair and its contacts, a range of the list they were appended to.
struct ContactHit {
  BodyId body;
  PairAnswer answer;
  std::size_t first = 0, count = 0;
};

/// The first touch of a moving shape with a body.
struct Impact {
  BodyId body;
  double t = 0;                                      ///< of the motion, [0, 1]; 0: they touch at the start
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  ///< as in PairAnswer: midway, from the shape to the body
  std::array<std::uint32_t, 2> feature{};            ///< of the shape and of the body: the triangle of a mesh, else 0
};

/// What is known of a configuration or of a motion.
enum class Verdict : std::uint8_t {
  free,
  hit,
  unknown,  ///< the deadline passed or a stop was requested before it was known
};

/// Poses of a batch, row by row: link j of configuration i stands at pose i * links + j. They lie somewhere, as poses
/// or as matrices, or are made when they are looked at, a few configurations at a time: by a robot's kinematics, or
/// from numbers in another form, without the time and memory that all of them would take.
class BatchPoses {
 public:
  /// Writes the poses from number `first` on. Called by any of the threads that check, for no pose twice; what it
  /// throws ends the batch and is thrown.
  using Maker = std::function<void(std::size_t first, std::span<Pose> poses)>;

  /// What lies must outlive the batch.
  template <std::convertible_to<std::span<const Pose>> Poses>
  BatchPoses(const Poses& poses) : lying_(poses), size_(lying_.size()) {}
  /// Throws std::invalid_argument without a function.
  BatchPoses(std::size_t size, Maker make) : size_(size), make_(std::move(make)) {
    if (!make_) throw std::invalid_argument("BatchPoses: make is empty, allowed: a function that writes the poses");
  }

  /// Homogeneous matrices of 4 x 4 numbers, row by row, one after the other, as numpy's (n, 4, 4): read where they lie.
  /// Throws std::invalid_argument unless the number of numbers is a multiple of 16. The batch throws where a fourth row
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
  std::span<const Pose> lying() const { return lying_; }          ///< empty where they are no poses, or are made
  std::span<const double> matrices() const { return matrices_; }  ///< their numbers; empty where they are none
  const Maker& make() const { return make_; }                     ///< empty where they lie

 private:
  BatchPoses() = default;
  std::span<const Pose> lying_;
  std::span<const double> matrices_;
  std::size_t size_ = 0;
  Maker make_;
};

/// How configurations are checked.
struct BatchOptions {
  double margin = 0;                 ///< metres, finite, >= 0: gaps up to this count as hits
  QueryFilter filter{};              ///< for all links
  const PairTable* world = nullptr;  ///< links x body indices: which are checked; null: all that the filter admits
  /// Configurations that follow one another and form a motion, of which one verdict is asked: is all of it free? They
  /// are looked at in the order that finds a hit soonest. Their number is a multiple of this; >= 1.
  std::size_t configurations_a_motion = 1;
  /// What lies between the configurations of a motion counts, too: every link goes from one to the next on a screw
  /// (Motion), and `free` is certified, not sampled. A gap below 1e-10 of the path may be told as a hit. `check` only.
  bool continuous = false;
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::stop_token stop{};  ///< as the deadline: reaches into pairs with a mesh
  std::function<void(std::size_t done, std::size_t all)> progress{};  ///< verdicts; from any thread, now and then
};

/// What a configuration or motion hits first: of its configurations the first that hits, of that the first pair of
/// links [link, other_link], else the first link and of the bodies that it hits the first by index.
struct FirstHit {
  Verdict verdict = Verdict::unknown;
  std::uint32_t configuration = 0;  ///< of the motion; this and all below: only where the verdict is `hit`
  std::uint32_t link = 0;
  std::uint32_t other_link = 0;  ///< where `body` names none
  BodyId body{};
};

/// What an update did.
struct UpdateReport {
  std::size_t changed = 0;  ///< bodies that came, went or moved
  bool rebuilt = false;     ///< the hierarchy was built anew, not refitted
  double ms = 0;            ///< wall
};

/// Asks a scene: which of its bodies does a shape meet, which is nearest, which does it meet first on its way, and that
/// for many configurations of a robot at once. A copy of the scene as it was at the last update is asked; the scene
/// itself may change meanwhile.
///
/// Const calls are safe from any number of threads at once and answer the same bits on any number; each runs on the
/// calling thread, but for `check`, `first_hits` and `clearance`, which use the oneTBB arena they are called in. Shapes
/// are tested themselves, never their boxes. All refuse with std::invalid_argument, naming it, a pose that is none, a
/// margin or cut-off that is negative or NaN, and pairs that NarrowPhase refuses.
class SceneQueries {
 public:
  /// `options`: the tolerance, solver and limit of all queries; its margin and cut-off are not used. Where the limit is
  /// reached, `check`, `first_hits` and `clearance` tell what they do not know, and all others throw WorkStopped.
  explicit SceneQueries(const Scene& scene, const NarrowPhaseOptions& options = {});
  ~SceneQueries();
  SceneQueries(SceneQueries&&) noexcept;
  SceneQueries& operator=(SceneQueries&&) noexcept;

  /// Takes over what changed in the scene, or another scene. Some that moved: a pass over all bodies' versions and a
  /// refit, k log n; those that come where none was, and another scene: n log n. Meshes that came are made ready
  /// (prepare.h), so that no query waits for it; the owner of a mesh that asks may make it ready in the same way.
  /// Where it throws (memory that there is not), queries throw std::logic_error until an update succeeds.
  UpdateReport update(const Scene& scene);
  std::size_t memory() const;  ///< bytes held, shapes not counted

  /// Is any body touched, or nearer than or as near as `margin`? Ends at the first.
  bool collides(const Shape& shape, const Pose& pose, double margin = 0, const QueryFilter& filter = {}) const;
  /// Bodies that are touched, by index; appended.
  void hits(const Shape& shape, const Pose& pose, std::vector<BodyId>& bodies, const QueryFilter& filter = {}) const;
  /// The body of the least signed distance that is at most `cutoff`, the first by index of several.
  std::optional<Hit> nearest(const Shape& shape, const Pose& pose,
                             double cutoff = std::numeric_limits<double>::infinity(),
                             const QueryFilter& filter = {}) const;
  /// Bodies whose signed distance is at most `margin`, by index; appended.
  void within(const Shape& shape, const Pose& pose, double margin, std::vector<Hit>& hits,
              const QueryFilter& filter = {}) const;
  /// Bodies with contacts, gaps up to `margin` included, by index, and the contacts; appended.
  void contacts(const Shape& shape, const Pose& pose, double margin, std::vector<ContactHit>& hits,
                std::vector<Contact>& contacts, const QueryFilter& filter = {}) const;
  /// The first body that the moving shape touches, the first by index of several; a sphere of radius 0 is a ray.
  std::optional<Impact> cast(const Shape& shape, const Motion& motion, const QueryFilter& filter = {}) const;

  /// Ask the same for a body of the scene where it is, by its groups and mask, itself left out and, if it is static,
  /// all that are. Throw std::invalid_argument unless the id is that of a body of the last update.
  bool collides(BodyId body, double margin = 0) const;
  void hits(BodyId body, std::vector<BodyId>& bodies) const;
  std::optional<Hit> nearest(BodyId body, double cutoff = std::numeric_limits<double>::infinity()) const;
  void within(BodyId body, double margin, std::vector<Hit>& hits) const;

  /// Checks configurations of links. Verdict i is `hit` where some link meets a body, or another link (pairs i < j that
  /// `self` has). Throws std::invalid_argument unless the sizes fit; links must be bounded.
  void check(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self, std::span<Verdict> verdicts,
             const BatchOptions& options = {}) const;
  /// Tells what each configuration hits first; not continuous. Slower than `check`, as the order of looking is not
  /// free.
  void first_hits(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                  std::span<FirstHit> hits, const BatchOptions& options = {}) const;
  /// The least signed distance of each configuration, of all its links from the bodies and from one another; `cutoff`
  /// where it is not less, minus infinity where the deadline passed or a stop was requested first.
  void clearance(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                 std::span<double> distances, double cutoff = std::numeric_limits<double>::infinity(),
                 const BatchOptions& options = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
