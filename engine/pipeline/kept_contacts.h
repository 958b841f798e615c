#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/kept_sums.h"
#include "pipeline/list_splice.h"
#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// Answers of the last step that may stand for this one's, in two ways.
///
/// A body rests while no point of it is farther than a thousandth of the tolerance from where it was when its rest
/// began. Two that have rested since their answer leave it as it is: it stays where it lies in the list, and says how
/// far they may have moved. Boxes of bodies hold them wherever they may be while they rest, so they are not made anew;
/// two whose boxes are those of the step before are candidates if they were, so that nobody need ask for them.
///
/// Else an answer is kept that was computed for poses of which no point of one body has moved by more than a bound,
/// seen from the other: it is moved with one of the two, the reference, and says the bound.
///
/// Whether an answer is kept, and how, depends on the poses alone. For convex bodies the signed distance changes by no
/// more than any point moves (the largest separation over all directions does, and each of them does), so the bound
/// holds for distance and depth, and an answer is kept only where it leaves the verdict beyond doubt, or who asks can
/// tell that it is as it was. Contacts of a mesh that it overlaps with are not moved along: its unproven depth, that of
/// the deepest contact, may jump from one pose to the next. They stand while both rest.
///
/// In a step any number of threads ask for different pairs at once; nothing is locked but where a batch tells what it
/// found. Nothing is searched where pairs come in order. What did not stand is then put in its place among what did;
/// where that was most of the pairs, all are asked for in the next step, and what stands is copied to where the others
/// go.
class KeptContacts {
 public:
  /// `request` contacts or distance; `tolerance` relative to the smaller body's size, > 0; gaps up to `margin` (metres)
  /// are contacts.
  KeptContacts(Request request, double tolerance, double margin)
      : distances_(request == Request::distance), tolerance_(tolerance), margin_(margin) {}

  /// Takes the last step's answer, and leaves `contacts` to what does not stand. `same_bodies`: no body has come or
  /// gone since the last step, nor has its part of the filter changed. True if only pairs of which a body does not rest
  /// and the restless ones need to be asked for; else all candidates must be.
  /// Throws WorkStopped where the limit ended the building of a mesh's hull.
  bool begin_step(const Scene& scene, ContactList& contacts, bool same_bodies, const WorkLimit& limit);
  /// Notes which of the bodies from `first` on rest, before any pair of theirs is asked for, and clears their bytes;
  /// others' poses were not written since the last step. From several threads, on different bodies.
  void update_rests(std::size_t first, std::span<std::uint8_t> changed);
  /// Candidates of the last step that are to be asked for even if both bodies rest.
  std::span<const Pair> restless() const { return restless_; }
  bool both_rest(Pair pair) const { return since_[pair.a] != step_ && since_[pair.b] != step_; }
  /// After a step that was not cut short; without it the next one keeps nothing. `contacts`: answers of the pairs that
  /// do not stand; of all of them after it.
  void end_step(ContactList& contacts);

  // For a scene that several have in parts. Between two steps:
  /// What is known of a body that the last step saw.
  std::optional<KeptRest> rest(const Scene& scene, std::uint32_t body) const;
  /// The last step's candidates of which `leaves` is true. `contacts`: the last step's answer.
  std::vector<KeptRecord> leaving(const ContactList& contacts, const std::function<bool(Pair)>& leaves) const;
  /// Bodies that have come, of which nothing else is kept any more, and candidates that were another one's in the last
  /// step, whose answers go into `contacts`.
  void take_in(const Scene& scene, ContactList& contacts, std::span<const KeptBody> bodies,
               std::vector<KeptRecord> pairs);
  /// Keeps nothing: as before the first step.
  void begin_anew();

  /// Where the body's rest began (its pose now, if it does not rest), and how far from there any of its points may be.
  Pose anchor(std::size_t body) const { return {anchor_rotations_[body], anchor_places_[body]}; }
  double reach(std::size_t body) const { return reach_[body]; }

  /// Of the last step's candidates.
  struct Counts {
    std::uint64_t candidates = 0, computed_pairs = 0, colliding_pairs = 0;
    std::uint64_t touching = 0, gaps = 0;  ///< contacts
    std::uint64_t inexact = 0;             ///< answers
    double max_depth = 0;
    double error_bound = 0;  ///< metres, the largest of a kept answer that is reported
  };
  Counts counts() const;
  std::size_t entries() const { return keys_.size(); }
  std::size_t memory() const;  ///< bytes

  /// A ball that holds a shape, in its frame.
  struct Ball {
    const void* shape = nullptr;  // names it
    Vec3 centre = Vec3::Zero();
    bool is_centred = true;  // there
    bool is_round = false;   // however it is turned, it is the same
    double radius = 0;       // infinite for a half-space
    double allowed = 0;      // metres: the tolerance times the size; infinite for a half-space
  };

  class Batch;

 private:
  static constexpr std::uint32_t none = KeptEntry::none;
  using Entry = KeptEntry;
  using Largest = KeptLargest;
  struct Fresh {
    std::uint64_t key = 0;
    Entry entry;
    Largest largest;
  };
  using Sums = KeptSums;

  static std::uint64_t key_of(Pair pair) { return std::uint64_t{pair.a} << 32 | pair.b; }
  static Pair pair_of(std::uint64_t key) {
    return {static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)};
  }
  const void* shape_now(std::size_t body, const Ball& ball) const;
  double reach_now(std::size_t body, const Ball& ball) const;
  bool is_as_it_was(std::size_t body, const Ball& ball) const;
  void end_rest(std::size_t body, const Ball& ball);
  double rest_bound(Pair pair) const { return 2 * (reach_[pair.a] + reach_[pair.b]); }
  bool stands(const Entry& entry, Pair pair) const {
    return entry.steady && since_[pair.a] <= entry.as_of && since_[pair.b] <= entry.as_of;
  }
  void clear();
  void resize(std::size_t bodies);
  void forget_gone();
  void take_fresh();
  std::uint32_t put_detail(KeptPair&& detail);
  void take_in_pairs(ContactList& contacts, std::span<KeptRecord> pairs);
  void find_rows();
  void find_columns();
  void add_columns();
  void mark_pairs_of_moved();
  void find_places();
  void find_restless();
  void take_over();
  void tell(std::size_t i, Pair pair, std::uint32_t place);
  void forget(std::size_t i);
  std::size_t place_of(Pair pair) const;
  std::uint32_t listed_between(std::size_t first, std::size_t last) const;
  std::size_t next_marked(std::size_t i) const;
  void update_list(std::size_t answers);
  void add_told();

  bool distances_;
  double tolerance_, margin_;
  const Scene* scene_ = nullptr;
  std::uint32_t step_ = 1;
  bool complete_ = true;
  bool same_bodies_ = false;            // as in the last step
  bool all_asked_ = true;               // in this step
  bool restless_known_ = false;         // restless_ holds the last step's
  std::atomic<bool> any_moved_{false};  // body

  std::vector<Shape> shapes_;  // of the last step's scene: as long as they are held, no other shape has their address
  std::vector<Ball> balls_;    // one a shape
  // One a body:
  std::vector<Vec3> anchor_places_;  // where its rest began, see anchor(); apart, as a ball's rotation is not read
  std::vector<Mat3> anchor_rotations_;
  std::vector<const void*> body_shapes_;  // as in Ball; null: no body
  std::vector<double> reach_;
  std::vector<std::uint32_t> since_;    // step in which its rest began
  std::vector<std::uint32_t> changed_;  // step in which it got another shape
  std::vector<std::uint8_t> arrived_;   // since the last step: nobody has its box yet; or empty

  ContactList last_;
  // One a pair that was a candidate, by (a, b):
  std::vector<std::uint64_t> keys_;  // a in the high half, b in the low one
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> listed_;  // whether it is in last_
  std::vector<Largest> largest_;
  std::vector<std::uint8_t> marked_;  // whether it is to be gone through in this step, for it may not be as it was

  std::vector<std::uint32_t> rows_;     // a body: its first entry as a; and one past the last of all
  std::vector<std::uint32_t> firsts_;   // the a of each pair, by (b, a)
  std::vector<std::uint32_t> columns_;  // a body: its first pair as b in firsts_; and one past the last; or empty
  std::vector<KeptPair> details_;
  std::vector<std::uint32_t> free_details_;
  std::vector<Pair> restless_;
  bool any_marked_ = false;             // in the last step, to be told
  std::vector<std::uint32_t> results_;  // a pair's place in last_, where all are asked for
  std::size_t candidates_ = 0, listed_pairs_ = 0;
  std::size_t noted_ = 0;  // did not stand in the last step
  Sums sums_;
  std::uint64_t computed_ = 0;

  std::vector<std::size_t> places_;
  std::vector<Splice> splices_;
  ListSplicer splicer_;

  std::mutex mutex_;  // of what batches tell:
  std::vector<Fresh> fresh_;
  std::vector<KeptPair> fresh_details_;
  std::vector<std::array<std::uint32_t, 2>> adopted_;  // an entry that had none, and its place in fresh_details_
  Sums told_;
};

}  // namespace tandem
