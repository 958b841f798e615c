// Contact caching over steps: which answers of the last step remain valid, and the data from which others are
// extrapolated.
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

/// Keeps answers of the last step that remain valid in this one, in two ways.
///
/// Resting pairs. A body rests while none of its points is farther than a thousandth of the tolerance from where it was
/// when the rest began. The answer of two bodies that have rested since it was computed remains as it is: it keeps its
/// position in the list, with the motion that the bodies may have made as its error bound. The box of a resting body
/// contains it wherever it may be while it rests, so it is not recomputed; two bodies with unchanged boxes are
/// candidates if they were before, so the broad phase need not report them.
///
/// Moved pairs. An answer is also kept if no point of one body has moved by more than a bound relative to the other
/// since the answer was computed: the contacts move with one of the two bodies, the reference, and the bound is
/// reported.
///
/// Whether and how an answer is kept depends on the poses alone. For convex bodies the signed distance changes by no
/// more than any point moves (it is the largest separation over all directions, and each separation changes by no
/// more), so the bound holds for distance and depth. An answer is kept only if the bound leaves no doubt about the
/// verdict, or the caller's query confirms it. Contacts of an overlap with a mesh do not move along: their unproven
/// depth, that of the deepest contact, may jump between poses. They remain only while both bodies rest.
///
/// In a step any number of threads process different pairs at once; only a batch's final report takes a lock. Pairs in
/// order need no search. Recomputed answers are then merged into the list; if they were most of the pairs, the next
/// step processes all pairs, and kept answers are copied.
class KeptContacts {
 public:
  /// `request`: contacts or distance; `tolerance`: relative to the smaller body's size, > 0; `margin`: metres, gaps up
  /// to this are contacts.
  KeptContacts(Request request, double tolerance, double margin)
      : distances_(request == Request::distance), tolerance_(tolerance), margin_(margin) {}

  /// Takes the last step's list, and leaves in `contacts` the answers to recompute. `same_bodies`: no body was added or
  /// removed since the last step, and no filter changed. True if the broad phase need only report pairs of bodies that
  /// do not rest and `restless` pairs; otherwise it must report all candidates. Throws WorkStopped if the limit ended
  /// the building of a mesh's hull.
  bool begin_step(const Scene& scene, ContactList& contacts, bool same_bodies, const WorkLimit& limit);
  /// Determines which of the bodies from `first` on rest, before any of their pairs is processed, and clears their
  /// bytes; the poses of other bodies were not written since the last step. Several threads may call it for different
  /// bodies.
  void update_rests(std::size_t first, std::span<std::uint8_t> changed);
  /// Candidates of the last step that must be processed even if both bodies rest.
  std::span<const Pair> restless() const { return restless_; }
  bool both_rest(Pair pair) const { return since_[pair.a] != step_ && since_[pair.b] != step_; }
  /// Ends a complete step; without this call the next step keeps nothing. `contacts`: on entry the recomputed answers,
  /// on return all.
  void end_step(ContactList& contacts);

  // For a scene that is distributed over several pipelines. To be called between two steps:
  /// The kept state of a body that was there in the last step.
  std::optional<KeptRest> rest(const Scene& scene, std::uint32_t body) const;
  /// The last step's candidates for which `leaves` is true. `contacts`: the last step's answer.
  std::vector<KeptRecord> leaving(const ContactList& contacts, const std::function<bool(Pair)>& leaves) const;
  /// Adds bodies that came from another pipeline, without other kept data, and the candidates that another pipeline had
  /// in the last step, whose answers go into `contacts`.
  void take_in(const Scene& scene, ContactList& contacts, std::span<const KeptBody> bodies,
               std::vector<KeptRecord> pairs);
  /// Discards all kept data, as before the first step.
  void begin_anew();

  /// The pose at which the body's rest began (its current pose if it does not rest), and the largest distance of its
  /// points from there.
  Pose anchor(std::size_t body) const { return {anchor_rotations_[body], anchor_places_[body]}; }
  double reach(std::size_t body) const { return reach_[body]; }

  /// Counts over the last step's candidates.
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
    std::uint64_t shape = 0;  // names it
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
  struct NewPair {
    std::uint64_t key = 0;
    Entry entry;
    Largest largest;
  };
  using Sums = KeptSums;

  static std::uint64_t key_of(Pair pair) { return std::uint64_t{pair.a} << 32 | pair.b; }
  static Pair pair_of(std::uint64_t key) {
    return {static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)};
  }
  std::uint64_t shape_now(std::size_t body, const Ball& ball) const;
  double reach_now(std::size_t body, const Ball& ball) const;
  bool is_as_it_was(std::size_t body, const Ball& ball) const;
  void end_rest(std::size_t body, const Ball& ball);
  double rest_bound(Pair pair) const { return 2 * (reach_[pair.a] + reach_[pair.b]); }
  bool remains_valid(const Entry& entry, Pair pair) const {
    return entry.steady && since_[pair.a] <= entry.as_of && since_[pair.b] <= entry.as_of;
  }
  void clear();
  void resize(std::size_t bodies);
  void forget_gone();
  void insert_new_pairs();
  std::uint32_t put_detail(KeptPair&& detail);
  void take_in_pairs(ContactList& contacts, std::span<KeptRecord> pairs);
  void find_rows();
  void find_columns();
  void add_columns();
  void mark_pairs_of_moved();
  void find_places();
  void find_restless();
  void take_over();
  void mark_resting(std::size_t i, Pair pair, std::uint32_t place);
  void forget(std::size_t i);
  std::size_t place_of(Pair pair) const;
  std::uint32_t listed_between(std::size_t first, std::size_t last) const;
  std::size_t next_marked(std::size_t i) const;
  void update_list(std::size_t answers);
  void add_batch_sums();

  bool distances_;
  double tolerance_, margin_;
  const Scene* scene_ = nullptr;
  std::uint32_t step_ = 1;
  bool complete_ = true;
  bool same_bodies_ = false;            // since the last step
  bool all_processed_ = true;           // in this step
  bool restless_known_ = false;         // restless_ holds the last step's
  std::atomic<bool> any_moved_{false};  // body

  std::vector<Shape> shapes_;  // of the last step's scene: while they are held, no other shape has their address
  std::vector<Ball> balls_;    // one per shape
  // One a body:
  std::vector<Vec3> anchor_places_;  // where its rest began, see anchor(); apart, as a ball's rotation is not read
  std::vector<Mat3> anchor_rotations_;
  std::vector<std::uint64_t> body_shapes_;  // as in Ball; 0: no body
  std::vector<double> reach_;
  std::vector<std::uint32_t> since_;    // step in which its rest began
  std::vector<std::uint32_t> changed_;  // step in which it got another shape
  std::vector<std::uint8_t> arrived_;   // since the last step: nobody has its box yet; or empty

  ContactList last_;
  // One element per pair that was a candidate, sorted by (a, b):
  std::vector<std::uint64_t> keys_;  // a in the high half, b in the low one
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> listed_;  // whether it is in last_
  std::vector<Largest> largest_;
  std::vector<std::uint8_t> marked_;  // whether the pair must be processed in this step, as its answer may have changed

  std::vector<std::uint32_t> rows_;    // per body: its first entry as a; and the end of the last body's
  std::vector<std::uint32_t> firsts_;  // the a of each pair, sorted by (b, a)
  // Per body: its first pair as b in firsts_; and the end of the last body's; or empty.
  std::vector<std::uint32_t> columns_;
  std::vector<KeptPair> details_;
  std::vector<std::uint32_t> free_details_;
  std::vector<Pair> restless_;
  bool any_marked_ = false;             // in the last step
  std::vector<std::uint32_t> results_;  // a pair's place in last_, if all pairs are processed
  std::size_t candidates_ = 0, listed_pairs_ = 0;
  std::size_t recorded_ = 0;  // pairs processed in the last step
  Sums sums_;
  std::uint64_t computed_ = 0;

  std::vector<std::size_t> places_;
  std::vector<Splice> splices_;
  ListSplicer splicer_;

  std::mutex mutex_;  // guards the batches' reports:
  std::vector<NewPair> new_pairs_;
  std::vector<KeptPair> new_details_;
  std::vector<std::array<std::uint32_t, 2>> adopted_;  // an entry that had none, and its place in new_details_
  Sums batch_sums_;
};

}  // namespace tandem
