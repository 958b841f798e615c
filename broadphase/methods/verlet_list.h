// Candidate pairs that are kept for several steps.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kept_candidates/candidate_tiles.h"
#include "kept_candidates/early_slab.h"
#include "kept_candidates/joint_stages.h"
#include "kept_candidates/returned_bodies.h"
#include "kept_candidates/returned_candidates.h"
#include "kernels/box_record.h"
#include "methods/box_search.h"
#include "methods/listed_method.h"
#include "storage/filter_copy.h"
#include "storage/memory.h"
#include "storage/page_vector.h"
#include "tandem/broadphase/broad_phase.h"
#include "tandem/broadphase/scratch_pool.h"

namespace tandem {

/// Keeps the candidates of a method for the following steps (Verlet, "Computer experiments on classical fluids", 1967).
/// The method is given enlarged boxes: each swept along its last motion for some steps, and grown a little. As long as
/// a box stays inside its enlarged one, all boxes that it overlaps are among the kept candidates; a step then only
/// tests these.
///
/// The pairs of a step are exact whatever the boxes do:
/// - Candidates are tested with the boxes of the step. A box that left its enlarged one gets another, with which the
///   boxes are searched once: those that it may overlap become candidates, too. A pair is a candidate if the enlarged
///   boxes of the two overlap, either the first ones or the last ones.
/// - When too many boxes have left, the list is made anew, at the cost of one step of the method; when they left all at
///   once, sooner than expected, one step is done from scratch first, so that the new list knows how they move. Whether
///   so many have left is estimated from a sample before the step, and counted after it.
/// - When lists do not last, none are made for a while.
///
/// A step that reuses a list has one serial stage of some microseconds and then the last stage, whose blocks are
/// independent: the first pairs leave at once. Its tiles read boxes in any order; therefore the boxes are copied to
/// records, with which every block first helps. While another thread still copies, a tile reads the boxes themselves,
/// which takes longer; the first tiles do so on purpose. Boxes declared unchanged are not read.
///
/// A step that renews the list also prepares that within its last stage, whose first block hands on the early pairs
/// (EarlySlab).
///
/// How far ahead boxes are swept is adapted so that making lists and using them cost about the same. All decisions are
/// made from counts, never from time.
class VerletList {
 public:
  /// Starts a step as BroadPhase::begin. `method` finds the pairs, of all boxes or of the enlarged ones.
  std::size_t begin(const BoxArray& boxes, ListedMethod& method);
  std::size_t blocks(std::size_t stage) const;
  void run(std::size_t stage, std::size_t block);
  void emit(std::size_t block, PairSink& sink);

  /// As BroadPhase::expect: pairs that the filter forbids when a list is made are not on it. A box whose filter entries
  /// have changed since then counts as one that left.
  void expect(const PairFilter& filter) { filter_ = filter; }
  /// As BroadPhase::expect_changes.
  void expect_changes(std::span<const std::uint8_t> changed) { next_changed_ = changed; }
  /// As BroadPhase::expect_only_changes.
  void expect_only_changes() { next_only_changes_ = true; }
  std::size_t memory() const;

  /// The work of a step, known before its last stage: from scratch, renewal of the list, or reuse.
  enum class Mode : std::uint8_t { scratch, renew, reuse };
  Mode mode() const { return mode_; }
  /// True if the method ran in the last step.
  bool method_ran() const { return mode_ != Mode::reuse; }
  /// Steps since the list was made.
  std::size_t age() const { return age_; }
  /// The number of boxes outside their enlarged ones; known once the step is done.
  std::size_t outside() const;
  /// Pairs on the list.
  std::size_t candidates() const { return listed_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t boxes_a_part = 4096, boxes_a_list = 256;
  static constexpr std::size_t first_method_stage = 1;  // after: decide

  struct Scratch {
    TileMaker maker;
    CandidateTiles tiles;
    std::array<BoxRecord, CandidateTiles::most_bodies> boxes;
    std::array<LocalPair, 512> hits;
    std::array<std::uint8_t, CandidateTiles::most_bodies> changed;
    std::vector<std::uint32_t> row, found;
    std::size_t memory() const { return maker.memory() + tiles.memory() + bytes_of(row) + bytes_of(found); }
  };
  /// Working memory for checking the boxes of a part.
  struct CheckScratch {
    std::array<std::uint32_t, boxes_a_part + 1> changed;
    std::array<std::uint32_t, boxes_a_part> outside;
    std::array<BoxRecord, boxes_a_part> past;
    static std::size_t memory() { return 0; }
  };
  /// Consecutive boxes that are checked together by one thread.
  struct Part {
    std::uint8_t checked = 0;  ///< written atomically in each step
    // The boxes outside in this step, to be put back before the next.
    std::vector<std::uint32_t> outside;
    BoxArray boxes, larger;   ///< the bounds of those outside, and the enlarged boxes that they get
    FilterCopy filter;        ///< the filter entries of those outside
    ReturnedCandidates list;  ///< the candidates of those that were put back
    // The boxes that may have changed in the last step for which that is known, and their enlarged boxes in a row.
    std::vector<std::uint32_t> changed;
    std::vector<BoxRecord> changed_larger;

    std::size_t memory() const {
      return bytes_of(outside) + boxes.memory() + larger.memory() + filter.memory() + list.memory() +
             bytes_of(changed) + bytes_of(changed_larger);
    }
  };
  class Found;
  class Tested;

  /// The first stage: chooses what this step does, and begins it.
  void decide();
  /// True if the list is good for this step. It is given up when boxes that left it have cost as much as a new list, or
  /// when it is old and has far too many candidates. Clears `foreseen` if boxes left sooner than expected.
  bool keeps_list(std::size_t changed, bool& foreseen);
  void reuse(std::size_t changed);
  /// True if a new list is worth making; counts the lists that did not pay.
  bool may_renew(bool foreseen);
  void begin_renewal();
  void rest();
  void prepare(std::size_t part);
  void adapt();
  /// True if the steps with this list, its making included, took less time than steps from scratch would have.
  bool paid() const;
  /// The usual motion and size, from a sample.
  UsualBox usual() const;
  /// True if boxes that continue their last motion would make a list of far more candidates than pairs, as after a
  /// shock.
  bool jolted() const;
  std::size_t count_outside(std::size_t first, std::size_t last) const;
  /// An estimate of the number of boxes outside, from a sample.
  std::size_t guess_outside() const;
  bool is_outside(std::size_t i) const;
  /// True if the two were candidates when the list was made.
  bool on_first_list(std::uint32_t a, std::uint32_t b) const;
  /// True if the two are candidates because one of them was put back.
  bool on_returned_list(std::uint32_t a, std::uint32_t b) const;
  Aabb first_box(std::uint32_t body) const { return returned_.has(body) ? returned_.first(body) : larger_[body]; }
  /// Handles two boxes of which the first is outside: reports the pair if it overlaps and is on no list, and keeps it
  /// if it is not on the first list and the filter allows it.
  void meet(std::uint32_t index, const Aabb& box, std::uint32_t other, const Aabb& others_box,
            std::vector<std::uint32_t>& kept, PairSink& sink) const;
  /// After a renewal: joins lists where most are short, so that they are read in a row; chooses the first ones to test.
  void pack();
  void put_together(std::size_t most_first, std::size_t most_together);
  const CandidateTiles& list(std::size_t block) const { return is_packed_ ? packed_[block] : lists_[block]; }
  /// Puts back the boxes that were outside in the step before.
  void put_back();
  std::size_t returned_candidates() const;

  /// Checks the parts that no thread has begun yet: copies their boxes and finds those outside. True if all parts are
  /// done, including those of other threads. `from_end`: begins with the last part; threads that start at different
  /// ends check the boxes that they have written themselves.
  bool help_check(bool from_end);
  void check_part(std::size_t part);
  /// Finds the boxes of a part that may have changed and are outside, with their records of the step before.
  std::size_t find_outside(std::size_t index, CheckScratch& scratch);
  /// True if a box declared unchanged really is; for assertions.
  bool is_as_before(std::size_t i) const;
  /// Waits, if need be, for the thread that checks the part. That thread waits for nothing.
  const Part& checked_part(std::size_t part) const;

  /// Prepares a renewal together with other threads; false if that failed.
  bool prepare_renewal();
  void renew_block(std::size_t block, Scratch& scratch, PairSink& sink);
  /// Tests the candidates and returns how many overlap. `all_copied`: there are records of all boxes.
  std::size_t test(const CandidateTiles& tiles, bool all_copied, Scratch& scratch, PairSink& sink);
  /// Tests only the candidates of a tile with a changed body; returns false, having done nothing, if many bodies have
  /// changed.
  bool test_changed(std::span<const std::uint32_t> bodies, std::span<const LocalPair> candidates, bool all_copied,
                    Scratch& scratch, PairSink& sink) const;
  bool overlap_now(std::uint32_t a, std::uint32_t b, bool all_copied) const {
    return all_copied ? overlap(records_[a], records_[b]) : overlap((*boxes_)[a], (*boxes_)[b]);
  }
  /// True if the step may leave out the pair.
  bool left_out(std::uint32_t a, std::uint32_t b) const { return only_changes_ && (changed_[a] | changed_[b]) == 0; }
  /// Puts the pairs of a tile into the sink.
  static void put_all(std::span<const LocalPair> pairs, const std::uint32_t* bodies, bool allowed, PairSink& sink);
  /// Puts the pairs of a tile into the sink, without the early ones.
  void put_later(std::span<const LocalPair> pairs, const std::uint32_t* bodies, const BoxRecord* boxes,
                 PairSink& sink) const;
  void test(const ReturnedCandidates& list, bool all_copied, PairSink& sink) const;
  void search_outside(Part& part, Scratch& scratch, PairSink& sink);
  /// Tests the boxes outside against each other.
  void test_outside(Scratch& scratch, PairSink& sink);

  std::size_t size() const { return boxes_->size(); }
  bool too_long() const;
  std::size_t part_end(std::size_t part) const { return std::min(size(), (part + 1) * boxes_a_part); }
  /// True if unchanged boxes need not be read.
  bool changes_known() const { return !changed_.empty() && (has_past_ || !copies_); }

  const BoxArray* boxes_ = nullptr;
  ListedMethod* method_ = nullptr;
  BoxSearch* search_ = nullptr;
  std::size_t method_stages_ = 0;
  Mode mode_ = Mode::scratch;
  bool without_list_ = false;  // this step is left to the method, without a list
  bool method_begun_ = false;  // the method's begin was called in our `begin`
  std::size_t steps_without_list_ = 0, failures_ = 0;

  std::span<const std::uint8_t> changed_, next_changed_;
  bool only_changes_ = false, next_only_changes_ = false;
  bool filtered_further_ = false;  // the sinks of the step filter again, such as for changes only
  PageVector<BoxRecord> records_;  // of the step before, until this step copies its boxes
  bool has_past_ = false;          // records_ are of the step before
  bool copies_ = true;             // this step copies its boxes
  bool is_resting_ = false;        // in this step no box changes, and no pair is asked for
  BoxArray larger_;
  double steps_ahead_ = 8;

  // The state of checking, by parts.
  std::atomic<std::uint64_t> next_part_{0};  // parts taken from the first on (high half) and from the last (low)
  std::atomic<std::size_t> parts_done_{0};
  mutable std::vector<Part> parts_;  // mutable only for std::atomic_ref
  std::size_t part_count_ = 0;

  std::vector<CandidateTiles> lists_, packed_;
  std::size_t list_count_ = 0;
  std::size_t first_lists_ = 1;  // lists that are tested while boxes are still being copied
  bool is_packed_ = false;       // short lists are together in packed_
  bool list_made_ = false;
  bool too_long_ = false;  // of the list of the step before
  std::atomic<std::size_t> blocks_done_{0}, listed_{0}, listed_bodies_{0}, hits_{0};
  std::size_t age_ = 0, outside_since_ = 0, outside_last_ = 0;
  UsualBox usual_;
  PairFilter filter_, list_filter_view_;
  FilterCopy list_filter_, last_filter_;  // as of the making of the list; as of the last body put back
  // True if the filter is what it was when the list was made: its pairs need no filtering.
  std::atomic<bool> filter_holds_{false};
  ReturnedBodies returned_;
  ReturnedCandidates among_;  // candidates among bodies put back in the same step
  BoxArray outside_boxes_;
  detail::ScratchPool<Scratch> scratch_;
  detail::ScratchPool<CheckScratch> check_scratch_;
  JointStages renewal_;
  EarlySlab early_;  // of a renewal
};

}  // namespace tandem
