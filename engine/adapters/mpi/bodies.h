#pragma once
#include <oneapi/tbb/task_arena.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "communicator.h"
#include "directory.h"
#include "records.h"
#include "regions.h"
#include "tandem/engine/scene.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// The bodies of one rank: those that it owns and copies of others', in a scene of its own, and what of them the other
/// ranks must be told.
class Bodies {
 public:
  Bodies(Communicator& communicator, double margin, int threads);

  Scene& scene() { return scene_; }
  const Scene& scene() const { return scene_; }
  ShapeId add_shape(Shape shape, std::string name);
  /// Of what tells the shapes apart; equal on all ranks if they have the same ones.
  std::uint64_t shapes_hash() const { return shapes_hash_; }

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
  std::size_t copies() const { return places_.size() - count_; }

  /// Checks a change's numbers as Scene does: std::invalid_argument that names the body by its id.
  BodyRecord checked(GlobalId id, const BodyOptions& body);
  /// Of a body that this rank owns (Kind::add: will own); throws std::invalid_argument.
  void apply(const Change& change);
  /// Takes back one that was added in this step.
  void forget(GlobalId id) { drop(places_.at(id)); }

  /// From now on removed bodies are kept in mind, for one who asks.
  void note_removed() { notes_removed_ = true; }
  std::vector<GlobalId> take_removed() { return std::exchange(removed_, {}); }

  /// Collective, with several ranks. Bodies go to their owners, copies to where boxes reach; all of them are looked at
  /// if `recut`.
  struct Sent {
    std::uint64_t moved_away = 0, bytes = 0, messages = 0;
  };
  Sent exchange(const Regions& regions, bool recut);
  /// Whether a pair of overlapping boxes is reported here.
  bool reports(const Regions& regions, std::uint32_t a, std::uint32_t b) const {
    if ((inside_[a] | inside_[b]) != 0) return true;
    std::array<double, 3> corner{};
    for (std::size_t i = 0; i < 3; ++i) corner[i] = std::max(boxes_[a].lo[i], boxes_[b].lo[i]);
    return regions.holds(corner);
  }
  const FloatBox& box(std::uint32_t index) const { return boxes_[index]; }
  /// Where a body is owned: the middle of its box in its own frame.
  Vec3 centre(std::uint32_t index) const;
  std::array<double, 3> place_of_centre(std::uint32_t index) const {
    const Vec3 middle = centre(index);
    return {middle.x(), middle.y(), middle.z()};
  }

  Directory& directory() { return directory_; }

 private:
  void apply_to(std::uint32_t index, const Change& change);
  void prepare(std::uint32_t index);
  std::uint32_t put(const BodyRecord& record, bool owned);
  void drop(std::uint32_t index);
  void look_at(std::uint32_t index, const Regions& regions);
  void tell_about(std::uint32_t index, const Regions& regions);
  void take(Letter& letter);
  Message& to(int rank);
  template <class Body>
  void for_each_index(const Body& body) const;

  Communicator& communicator_;
  double margin_;                           // boxes are grown by half of it
  std::unique_ptr<tbb::task_arena> arena_;  // null: the caller's
  bool alone_;                              // one thread
  Directory directory_;
  Scene scene_, door_;         // door_: has the shapes alone, and looks at what comes in
  std::vector<Vec3> centres_;  // one a shape: the middle of its box
  std::uint64_t shapes_hash_ = 0;

  std::unordered_map<GlobalId, std::uint32_t> places_;
  std::size_t count_ = 0;
  // One an index of the scene:
  std::vector<GlobalId> ids_;
  std::vector<std::uint8_t> owned_;
  std::vector<std::uint8_t> resend_;  // more of it has changed than its pose
  std::vector<std::uint8_t> inside_;  // its box lies in the rank's region
  std::vector<std::uint8_t> fresh_;   // its box was made anew in this step
  std::vector<std::uint32_t> seen_;   // version for which its box is
  std::vector<FloatBox> boxes_;
  std::vector<std::vector<int>> copies_;  // of an owned body: ranks that have one, ascending

  bool notes_removed_ = false;
  std::vector<GlobalId> removed_;

  std::vector<Letter> letters_, received_;
  std::vector<int> letter_of_;  // a rank's place in letters_, -1: none
  std::size_t used_ = 0;
  std::uint64_t moved_away_ = 0;
};

}  // namespace tandem::mpi
