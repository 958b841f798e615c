// The bodies of a rank, and their exchange with other ranks.
#pragma once
#include <oneapi/tbb/task_arena.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "answers/word_hash.h"
#include "communicator.h"
#include "directory.h"
#include "pipeline/kept_handover.h"
#include "records.h"
#include "regions.h"
#include "scene/scene_changes.h"
#include "tandem/engine/scene.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// The bodies of one rank: those that it owns and copies of others', in a scene of its own, and the changes that other
/// ranks have to receive.
///
/// Most bodies are far from every other region. As long as a ball about such a body stays in the rank's own region,
/// nothing is sent for it, and no step checks it; move() detects when it leaves. All others have an Edge: their boxes,
/// and the ranks that have copies, which stay the same while the box stays inside its box at their choice, enlarged by
/// a skin (Verlet 1967). A step in which no body leaves its skin sends poses alone, to ranks that expect them.
class Bodies {
 public:
  /// `rest`: as a fraction of its size, how far a body may be from the pose of its kept answers; 0: none are kept.
  Bodies(Communicator& communicator, const Regions& regions, double margin, int threads, double rest = 0);
  /// From now on the data of `kept`, which must outlive this object, travel with bodies.
  void keep_with(const KeptHandover& kept) { kept_ = &kept; }

  Scene& scene() { return scene_; }
  const Scene& scene() const { return scene_; }
  ShapeId add_shape(Shape shape, std::string name);
  /// A hash of what distinguishes the shapes; equal on all ranks if they have the same shapes.
  std::uint64_t shapes_hash() const { return shapes_hash_.value(); }

  bool has(GlobalId id) const { return places_.contains(id); }
  std::optional<std::uint32_t> place(GlobalId id) const {
    const auto found = places_.find(id);
    return found == places_.end() ? std::nullopt : std::optional(found->second);
  }
  bool owns(std::uint32_t index) const { return owned_[index] != 0; }
  bool owns_id(GlobalId id) const {
    const auto index = place(id);
    return index && owns(*index);
  }
  GlobalId id(std::uint32_t index) const { return ids_[index]; }
  std::size_t owned() const { return count_; }
  /// A counter that grows whenever a body arrives, leaves or changes its owner.
  std::uint64_t changes() const { return changes_; }
  std::size_t copies() const { return places_.size() - count_; }

  /// Moves a body, as Scene::move does, and notes whether it leaves the interior where no other rank need know of it.
  /// Several threads may move different bodies.
  void move(std::uint32_t index, const Pose& pose, const Vec3& velocity, const Vec3& angular_velocity) {
    scene_.move(index, pose, velocity, angular_velocity);
    if (owned_[index] != 0 && edge_of_[index] == no_edge && !is_calm(index)) unchecked_[index] = 1;
  }

  /// Checks the numbers of a change as Scene does: std::invalid_argument that names the body by its id.
  BodyRecord checked(GlobalId id, const BodyOptions& body);
  /// Applies a change to a body that this rank owns (Kind::add: will own); throws std::invalid_argument.
  void apply(const Change& change);
  /// Removes a body that was added in this step, as if it had not been.
  void forget(GlobalId id) { drop(places_.at(id)); }

  /// From now on the ids of removed bodies are recorded, for a response.
  void note_removed() { notes_removed_ = true; }
  std::vector<GlobalId> take_removed() { return std::exchange(removed_, {}); }

  /// Checks the bodies that have moved since the last exchange, and writes the messages for those whose copies stay on
  /// the same ranks. False if a rank would get a message that it does not expect.
  bool check_ahead();
  /// After an exception of check_ahead(), when no message has been sent yet: discards its messages, so that the
  /// exchange checks all bodies near other regions again.
  void check_again() noexcept;

  struct Sent {
    std::uint64_t moved_away = 0, bytes = 0, messages = 0;
    std::chrono::steady_clock::time_point begin, packed, got, end;
    double cpu_ms = 0;  ///< without waiting
  };
  /// Collective, with several ranks. Sends bodies to their owners, and copies to the ranks into whose regions boxes
  /// reach; checks all bodies if `recut`: the regions have changed since the last exchange. `expected`: check_ahead()
  /// was true on all ranks, and nothing has changed since.
  Sent exchange(bool recut, bool expected);
  /// True if a body's box lay in the rank's region in the last exchange: no other rank reports a pair of it.
  bool is_inside(std::uint32_t index) const { return inside_[index] != 0; }
  /// True if a pair of overlapping boxes is reported by this rank.
  bool reports(std::uint32_t a, std::uint32_t b) const {
    if ((inside_[a] | inside_[b]) != 0) return true;
    const FloatBox &box_a = edges_[edge_of_[a]].box, &box_b = edges_[edge_of_[b]].box;
    std::array<double, 3> corner{};
    for (std::size_t i = 0; i < 3; ++i) corner[i] = std::max(box_a.lo[i], box_b.lo[i]);
    return regions_.holds(corner);
  }
  // For kept answers, after an exchange: the id of the body that had an index in the last step.
  GlobalId last_id(std::uint32_t index) const {
    return departure_of_[index] != no_edge ? departures_[departure_of_[index]].id : ids_[index];
  }
  /// The rank that now reports a pair that this rank reported in the last step, by the indices of that step; -1: the
  /// boxes no longer overlap.
  int reporter(Pair last) const;
  /// The bodies that have arrived since the last step.
  std::span<const KeptBody> arrivals() const { return arrivals_; }
  void forget_past();

  // Between two exchanges a rank may need a body that it does not have. True if a rank has a copy:
  bool has_copy(std::uint32_t index, int rank) const;
  /// Writes an owned body to a rank that has no copy; if the body moves, the next exchange decides anew who needs one.
  void write_missing_copy(std::uint32_t index, int rank, Message& message);
  /// Stores the copies that other ranks have written.
  void take_missing_copies(RankMessage& message);

  /// The rank that owns a body that is on this rank.
  int owner(std::uint32_t index) const {
    return owned_[index] != 0 ? communicator_.rank() : edges_[edge_of_[index]].owner;
  }
  /// Visits owned bodies that moved after their poses were sent to the ranks with copies: visit(index, ranks).
  template <class Visit>
  void each_untold(const Visit& visit) const {
    const auto versions = SceneChanges::versions(scene_);
    for (const Edge& one : edges_)
      if (one.index != no_edge && owned_[one.index] != 0 && !one.copies.empty() && one.seen != versions[one.index])
        visit(one.index, std::span<const int>(one.copies));
  }
  /// Updates a copy that was moved after the exchange; the next exchange sends it again.
  void move_copy(const MotionRecord& motion) {
    scene_.move(places_.at(motion.id), motion.pose(), motion.speed(), motion.spin());
  }
  /// The point that decides who owns a body: the centre of its box in its own frame.
  Vec3 centre(std::uint32_t index) const;
  std::array<double, 3> place_of_centre(std::uint32_t index) const {
    const Vec3 middle = centre(index);
    return {middle.x(), middle.y(), middle.z()};
  }

  Directory& directory() { return directory_; }

 private:
  static constexpr std::uint32_t no_edge = 0xffffffffu;

  /// The state of a body that is a copy, or near other ranks' regions.
  struct Edge {
    std::uint32_t index = 0;
    std::uint32_t seen = 0;  // version of the body that the box is of
    FloatBox box;
    FloatBox skin;            // while an owned body's box stays in it, its copies are on the right ranks
    std::vector<int> copies;  // for an owned body: ranks with a copy, ascending
    int owner = 0;            // for a copy
  };
  /// For a shape, in its own frame: a ball that contains its box in every orientation.
  struct Ball {
    Vec3 centre = Vec3::Zero();
    double radius = 0;
    double reach = 0;  // radius of a ball about the origin that contains this one
    double grow = 0;   // growth of the box on each side: half the margin, and the deviation of a body at rest
  };
  /// A body that was on this rank in the last step and no longer is, with its present box.
  struct Departure {
    GlobalId id = 0;
    FloatBox box;
  };

  void apply_to(std::uint32_t index, const Change& change);
  void prepare(std::uint32_t index);
  std::uint32_t put(const BodyRecord& record, bool owned);
  void drop(std::uint32_t index);
  bool is_calm(std::uint32_t index) const;
  bool is_in_skin(const Edge& edge) const;
  double skin(std::uint32_t index) const;
  FloatBox box_now(std::uint32_t index, double skin) const;
  void put_body(Message& message, Item item, std::uint32_t index) const;
  std::uint32_t take_body(Message& message, bool owned);
  void update(std::uint32_t index, const BodyRecord& record);
  Edge& edge(std::uint32_t index);
  void give_back_edge(std::uint32_t index);
  void take_box(Edge& edge, const FloatBox& box);
  void check_all();
  void check_moved();
  void queue(std::uint32_t index);
  bool are_expected(std::uint32_t index) const;
  void renew(std::uint32_t index);
  void write_copies(const Edge& edge, int owner, std::span<const int> wanted);
  void give_to(int owner, std::uint32_t index, std::span<const int> wanted, bool stays);
  void add_neighbours(bool recut);
  void take(RankMessage& message);
  Message& to(int rank);
  template <class Body>
  void for_each_index(const Body& body) const;

  Communicator& communicator_;
  const Regions& regions_;
  double margin_;  // boxes are grown by half of it
  double rest_;
  const KeptHandover* kept_ = nullptr;
  std::unique_ptr<tbb::task_arena> arena_;  // null: the caller's
  bool alone_;                              // a single thread
  Directory directory_;
  Scene scene_;
  Scene door_;  // checks new bodies; holds the shape that it checked last
  std::uint32_t door_shape_ = 0;
  std::vector<Ball> balls_;  // one for each shape
  WordHash shapes_hash_{0};

  std::unordered_map<GlobalId, std::uint32_t> places_;
  std::size_t count_ = 0;
  std::uint64_t changes_ = 0;
  // Arrays with an element for each index of the scene:
  std::vector<GlobalId> ids_;
  std::vector<std::uint8_t> owned_;
  std::vector<std::uint8_t> resend_;     // more of it has changed than its pose
  std::vector<std::uint8_t> inside_;     // its box lies in the rank's region
  std::vector<std::uint8_t> unchecked_;  // an owned body without an edge that must be checked
  std::vector<std::uint8_t> queued_;     // it is in todo_
  std::vector<std::uint8_t> is_new_;     // it has arrived since the last step
  // For the body that had this index in the last step: its place in departures_.
  std::vector<std::uint32_t> departure_of_;
  std::vector<std::uint32_t> edge_of_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> free_edges_;
  Region calm_;                      // a ball in it reaches into no other rank's region, as of the last exchange
  std::vector<std::uint32_t> todo_;  // bodies whose copies, or owner, may change

  std::vector<Departure> departures_;
  std::vector<KeptBody> arrivals_;

  bool notes_removed_ = false;
  std::vector<GlobalId> removed_;

  std::vector<RankMessage> outgoing_, received_;
  std::vector<int> message_of_;  // the place of a rank's message in outgoing_, -1: none
  std::size_t used_ = 0;
  // Ranks with which this one has exchanged messages since the last cut; in most steps there are messages between these
  // alone.
  std::vector<int> neighbours_;
  std::vector<std::uint8_t> is_neighbour_;  // one for each rank
  bool expected_ = true;                    // no message goes to a rank that is not a neighbour
  std::uint64_t moved_away_ = 0;
};

}  // namespace tandem::mpi
