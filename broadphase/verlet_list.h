#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "box_record.h"
#include "box_search.h"
#include "candidate_tiles.h"
#include "listed_method.h"
#include "memory.h"
#include "page_vector.h"
#include "scratch_pool.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// Keeps what a method found for the steps to come (Verlet, "Computer experiments on classical fluids", 1967). The
/// method is given larger boxes: each swept along its last motion for some steps, and grown a little. As long as a
/// box stays inside its larger one, whatever it overlaps is among the candidates kept; a step then only tests these.
///
/// The pairs of a step are exact whatever the boxes do:
/// - What is on the list is tested with the boxes of the step, wherever they are. A box that left its larger one is
///   searched for as well; what it finds is reported if it is not on the list, which the two larger boxes tell.
/// - When too many have left, the list is made anew, at the cost of one step of the method; when they left all at
///   once, sooner than foreseen, one step is done from scratch first, so that the new list knows how they move.
///   Whether so many have left is judged from a sample before the step, and counted after it.
/// - When lists do not last, no more are made for a while.
///
/// A step that reuses a list has one serial stage of some microseconds and then the last, whose blocks need nothing
/// from each other: the first pairs leave at once. Its tiles read boxes in any order, for which they are copied to
/// records; every block first helps with that. As long as another thread is at it, a tile reads the boxes themselves,
/// which takes longer; so do the first tiles, on purpose.
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
  std::size_t memory() const;

  /// What the step does; known once its stages before the last are done.
  enum class Mode : std::uint8_t { scratch, renew, reuse };
  Mode mode() const { return mode_; }
  /// Whether the method ran in the last step.
  bool method_ran() const { return mode_ != Mode::reuse; }
  /// Steps since the list was made.
  std::size_t age() const { return age_; }
  /// Boxes that have left their larger ones; known once the step is done.
  std::size_t outside() const;
  /// Pairs on the list.
  std::size_t candidates() const { return listed_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t boxes_a_part = 4096;
  static constexpr std::size_t first_method_stage = 2;               // after: decide, prepare
  static constexpr std::size_t own_stages = first_method_stage + 1;  // and: make room

  struct Scratch {
    TileMaker maker;
    CandidateTiles tiles;
    std::array<BoxRecord, CandidateTiles::most_bodies> boxes;
    std::array<LocalPair, 512> hits;
    std::vector<std::uint32_t> row, outside;
    std::size_t memory() const { return maker.memory() + tiles.memory() + bytes_of(row) + bytes_of(outside); }
  };
  class Found;
  class Tested;

  void decide();
  void prepare(std::size_t part);
  void adapt();
  /// Whether the list, from its making to now, took less than steps from scratch would have.
  bool paid() const;
  /// From a sample.
  UsualBox usual() const;
  /// Whether boxes that go on as in the last step make a list of far more candidates than pairs: as after a shock.
  bool jolted() const;
  /// About how many boxes are outside, from a sample.
  std::size_t guess_outside() const;
  bool is_outside(std::size_t i) const;
  /// Whether the two were candidates when the list was made.
  bool on_list(std::uint32_t a, std::uint32_t b) const;

  /// Copies the boxes of the parts that nobody has begun yet. Whether all are done, others' too.
  bool help_copy();
  void find_outside(std::size_t part, BoxRecord* records, std::vector<std::uint32_t>& outside) const;
  /// Those of a part, if need be into `room`.
  const std::vector<std::uint32_t>& outside_of(std::size_t part, std::vector<std::uint32_t>& room) const;

  void renew_block(std::size_t block, Scratch& scratch, PairSink& sink);
  /// Tests the candidates and returns how many overlap. `all_copied`: there are records of all boxes.
  std::size_t test(const CandidateTiles& tiles, bool all_copied, Scratch& scratch, PairSink& sink) const;
  void search_outside(std::size_t part, Scratch& scratch, PairSink& sink);
  void test_outside(Scratch& scratch, PairSink& sink);

  std::size_t size() const { return boxes_->size(); }
  bool too_long() const;
  /// The stage after the method's but its last.
  std::size_t room_stage() const { return first_method_stage + method_stages_ - 1; }
  std::size_t parts() const { return (size() + boxes_a_part - 1) / boxes_a_part; }
  std::size_t part_end(std::size_t part) const { return std::min(size(), (part + 1) * boxes_a_part); }
  PageVector<BoxRecord>& now() { return records_[now_]; }
  const PageVector<BoxRecord>& now() const { return records_[now_]; }
  const PageVector<BoxRecord>& past() const { return records_[1 - now_]; }

  /// The filter that a list was made with.
  struct FilterCopy {
    std::vector<std::uint32_t> group, mask;
    std::vector<std::uint8_t> is_static;

    void take(const PairFilter& filter);
    bool same_arrays(const PairFilter& filter) const;
    /// Whether `filter` is the same for boxes [first, last).
    bool same(const PairFilter& filter, std::size_t first, std::size_t last) const;
    PairFilter view() const { return {group, mask, is_static}; }
  };

  const BoxArray* boxes_ = nullptr;
  ListedMethod* method_ = nullptr;
  BoxSearch* search_ = nullptr;
  std::size_t method_stages_ = 0;
  Mode mode_ = Mode::scratch;
  bool bare_ = false;          // this step is the method's alone, and leaves no trace here
  bool method_begun_ = false;  // in `begin` already
  std::size_t bare_steps_left_ = 0, failures_ = 0;

  std::array<PageVector<BoxRecord>, 2> records_;  // of this step and of the one before
  std::size_t now_ = 0;
  bool has_past_ = false;
  bool copies_ = true;  // this step fills its records
  bool fresh_ = false;  // they have never been written
  BoxArray larger_;
  double steps_ahead_ = 8;

  // What is copied in a step, by parts.
  std::atomic<std::size_t> next_part_{0}, parts_copied_{0};
  mutable std::vector<std::uint8_t> part_copied_;  // atomically; mutable only for std::atomic_ref
  std::vector<std::vector<std::uint32_t>> outside_of_part_;

  std::vector<CandidateTiles> lists_;  // one a block of the method
  std::size_t list_count_ = 0;
  bool list_made_ = false;
  bool too_long_ = false;  // the list of the step before
  std::atomic<std::size_t> blocks_done_{0}, listed_{0}, listed_bodies_{0}, hits_{0};
  std::size_t age_ = 0, outside_since_ = 0, outside_last_ = 0;
  UsualBox usual_;
  PairFilter filter_, list_filter_view_;
  FilterCopy list_filter_;
  BoxArray outside_boxes_;
  ScratchPool<Scratch> scratch_;
};

}  // namespace tandem
