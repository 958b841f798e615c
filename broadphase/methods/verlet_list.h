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

/// Keeps what a method found for the steps to come (Verlet, "Computer experiments on classical fluids", 1967). The
/// method is given larger boxes: each swept along its last motion for some steps, and grown a little. As long as a
/// box stays inside its larger one, whatever it overlaps is among the candidates kept; a step then only tests these.
///
/// The pairs of a step are exact whatever the boxes do:
/// - What is on the list is tested with the boxes of the step, wherever they are. A box that left its larger one gets
///   another, which is searched for once: what it may meet is then on the list, too. A pair is there if the larger
///   boxes of the two overlap, those of the start or the last ones.
/// - When too many have left, the list is made anew, at the cost of one step of the method; when they left all at
///   once, sooner than foreseen, one step is done from scratch first, so that the new list knows how they move.
///   Whether so many have left is judged from a sample before the step, and counted after it.
/// - When lists do not last, no more are made for a while.
///
/// A step that reuses a list has one serial stage of some microseconds and then the last, whose blocks need nothing
/// from each other: the first pairs leave at once. Its tiles read boxes in any order, for which they are copied to
/// records; every block first helps with that. As long as another thread is at it, a tile reads the boxes themselves,
/// which takes longer; so do the first tiles, on purpose. Boxes that are said not to have changed are not read.
///
/// A step that renews the list prepares that within its last stage, too, whose first block hands on the early pairs
/// (EarlySlab).
///
/// How far ahead boxes are swept is adapted so that making lists and testing what is on them cost about the same. All
/// decisions are made from counts, never from time.
class VerletList {
 public:
  /// Starts a step as BroadPhase::begin. `method` finds the pairs, of all boxes or of the larger ones.
  std::size_t begin(const BoxArray& boxes, ListedMethod& method);
  std::size_t blocks(std::size_t stage) const;
  void run(std::size_t stage, std::size_t block);
  void emit(std::size_t block, PairSink& sink);

  /// As BroadPhase::expect: pairs that the filter forbids when a list is made are not on it. A box whose part of the
  /// filter has changed since counts as one that left.
  void expect(const PairFilter& filter) { filter_ = filter; }
  /// As BroadPhase::expect_changes.
  void expect_changes(std::span<const std::uint8_t> changed) { next_changed_ = changed; }
  /// As BroadPhase::expect_only_changes.
  void expect_only_changes() { next_only_changes_ = true; }
  std::size_t memory() const;

  /// What the step does; known once its stages before the last are done.
  enum class Mode : std::uint8_t { scratch, renew, reuse };
  Mode mode() const { return mode_; }
  /// Whether the method ran in the last step.
  bool method_ran() const { return mode_ != Mode::reuse; }
  /// Steps since the list was made.
  std::size_t age() const { return age_; }
  /// Boxes that were found outside of their larger ones; known once the step is done.
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
  /// What the boxes of a part are checked with.
  struct CheckScratch {
    std::array<std::uint32_t, boxes_a_part + 1> changed;
    std::array<std::uint32_t, boxes_a_part> outside;
    std::array<BoxRecord, boxes_a_part> past;
    static std::size_t memory() { return 0; }
  };
  /// Boxes that are checked together.
  struct Part {
    std::uint8_t checked = 0;  ///< in this step; atomically
    // Those outside in this step, to be put back before the next.
    std::vector<std::uint32_t> outside;
    BoxArray boxes, larger;   ///< theirs, and the larger ones that they get
    FilterCopy filter;        ///< their part of it
    ReturnedCandidates list;  ///< of those that were put back
    // Those that may have changed in the last step for which that is known, and their larger boxes side by side.
    std::vector<std::uint32_t> changed;
    std::vector<BoxRecord> changed_larger;

    std::size_t memory() const {
      return bytes_of(outside) + boxes.memory() + larger.memory() + filter.memory() + list.memory() +
             bytes_of(changed) + bytes_of(changed_larger);
    }
  };
  class Found;
  class Tested;

  /// The first stage: this step's mode, and its beginning.
  void decide();
  /// Whether the list is good for this step: it goes when what left it has cost as much as a new one, or it is old and
  /// has more than it needs. `foreseen` is cleared where boxes left it sooner than was expected of it.
  bool keeps_list(std::size_t changed, bool& foreseen);
  void reuse(std::size_t changed);
  /// Whether a new list is worth making; counts those that were not.
  bool may_renew(bool foreseen);
  void begin_renewal();
  void rest();
  void prepare(std::size_t part);
  void adapt();
  /// Whether the list, from its making to now, took less than steps from scratch would have.
  bool paid() const;
  /// From a sample.
  UsualBox usual() const;
  /// Whether boxes that go on as in the last step make a list of far more candidates than pairs: as after a shock.
  bool jolted() const;
  std::size_t count_outside(std::size_t first, std::size_t last) const;
  /// About how many boxes are outside, from a sample.
  std::size_t guess_outside() const;
  bool is_outside(std::size_t i) const;
  /// Whether the two were candidates when the list was made.
  bool on_first_list(std::uint32_t a, std::uint32_t b) const;
  /// Whether they are candidates now for one of them was put back.
  bool on_returned_list(std::uint32_t a, std::uint32_t b) const;
  Aabb first_box(std::uint32_t body) const { return returned_.has(body) ? returned_.first(body) : larger_[body]; }
  /// What is to be done with two of which the first is outside: a pair that overlaps and is on no list is reported, one
  /// that is not on the first list is kept, if the filter allows it.
  void meet(std::uint32_t index, const Aabb& box, std::uint32_t other, const Aabb& others_box,
            std::vector<std::uint32_t>& kept, PairSink& sink) const;
  /// After a renewal: puts lists together where most are short, so that they are read in a row; chooses the first ones.
  void pack();
  void put_together(std::size_t most_first, std::size_t most_together);
  const CandidateTiles& list(std::size_t block) const { return is_packed_ ? packed_[block] : lists_[block]; }
  /// Puts back what was outside in the step before.
  void put_back();
  std::size_t returned_candidates() const;

  /// Checks the parts that nobody has begun yet: copies their boxes and finds those outside. Whether all are done,
  /// others' too.
  bool help_check();
  void check_part(std::size_t part);
  /// Those that may have changed and are outside; with the records that they had.
  std::size_t find_outside(std::size_t index, CheckScratch& scratch);
  /// Whether a box that is said not to have changed has not.
  bool is_as_before(std::size_t i) const;
  /// Waits for the thread that checks it, if it is not done. That one waits for nothing.
  const Part& checked_part(std::size_t part) const;

  /// Does what is to be done before candidates are found, with others; false when that failed.
  bool prepare_renewal();
  void renew_block(std::size_t block, Scratch& scratch, PairSink& sink);
  /// Tests the candidates and returns how many overlap. `all_copied`: there are records of all boxes.
  std::size_t test(const CandidateTiles& tiles, bool all_copied, Scratch& scratch, PairSink& sink);
  /// Tests the candidates of a tile of which a body has changed; false, and nothing is done, where many have.
  bool test_changed(std::span<const std::uint32_t> bodies, std::span<const LocalPair> candidates, bool all_copied,
                    Scratch& scratch, PairSink& sink) const;
  bool overlap_now(std::uint32_t a, std::uint32_t b, bool all_copied) const {
    return all_copied ? overlap(records_[a], records_[b]) : overlap((*boxes_)[a], (*boxes_)[b]);
  }
  /// Whether nobody asks for the pair.
  bool left_out(std::uint32_t a, std::uint32_t b) const { return only_changes_ && (changed_[a] | changed_[b]) == 0; }
  /// Hands on the pairs of a tile.
  static void put_all(std::span<const LocalPair> pairs, const std::uint32_t* bodies, bool allowed, PairSink& sink);
  /// Hands on the pairs of a tile but for the early ones.
  void put_later(std::span<const LocalPair> pairs, const std::uint32_t* bodies, const BoxRecord* boxes,
                 PairSink& sink) const;
  void test(const ReturnedCandidates& list, bool all_copied, PairSink& sink) const;
  void search_outside(Part& part, Scratch& scratch, PairSink& sink);
  /// Those outside against each other.
  void test_outside(Scratch& scratch, PairSink& sink);

  std::size_t size() const { return boxes_->size(); }
  bool too_long() const;
  std::size_t part_end(std::size_t part) const { return std::min(size(), (part + 1) * boxes_a_part); }
  /// Whether boxes that have not changed need not be read.
  bool changes_known() const { return !changed_.empty() && (has_past_ || !copies_); }

  const BoxArray* boxes_ = nullptr;
  ListedMethod* method_ = nullptr;
  BoxSearch* search_ = nullptr;
  std::size_t method_stages_ = 0;
  Mode mode_ = Mode::scratch;
  bool bare_ = false;          // this step is the method's alone, and leaves no trace here
  bool method_begun_ = false;  // in `begin` already
  std::size_t bare_steps_left_ = 0, failures_ = 0;

  std::span<const std::uint8_t> changed_, next_changed_;
  bool only_changes_ = false, next_only_changes_ = false;
  bool filtered_further_ = false;  // by the sinks of the step, which may take changes alone
  PageVector<BoxRecord> records_;  // of the step before, until this one copies its boxes
  bool has_past_ = false;          // they are of the step before
  bool copies_ = true;             // this step does
  bool is_resting_ = false;        // in this step no box changes, and nothing is asked for
  BoxArray larger_;
  double steps_ahead_ = 8;

  // What is checked in a step, by parts.
  std::atomic<std::size_t> next_part_{0}, parts_done_{0};
  mutable std::vector<Part> parts_;  // mutable only for std::atomic_ref
  std::size_t part_count_ = 0;

  std::vector<CandidateTiles> lists_, packed_;
  std::size_t list_count_ = 0;
  std::size_t first_lists_ = 1;  // are tested while boxes are still being copied
  bool is_packed_ = false;       // short lists are together in packed_
  bool list_made_ = false;
  bool too_long_ = false;  // the list of the step before
  std::atomic<std::size_t> blocks_done_{0}, listed_{0}, listed_bodies_{0}, hits_{0};
  std::size_t age_ = 0, outside_since_ = 0, outside_last_ = 0;
  UsualBox usual_;
  PairFilter filter_, list_filter_view_;
  FilterCopy list_filter_, last_filter_;  // when the list was made; when a body was last put on it
  // The filter is what it was when the list was made: what is on it need not be filtered.
  std::atomic<bool> filter_holds_{false};
  ReturnedBodies returned_;
  ReturnedCandidates among_;  // of those put back in the same step
  BoxArray outside_boxes_;
  detail::ScratchPool<Scratch> scratch_;
  detail::ScratchPool<CheckScratch> check_scratch_;
  JointStages renewal_;
  EarlySlab early_;  // of a renewal
};

}  // namespace tandem
