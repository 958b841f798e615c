#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "box_record.h"
#include "box_search.h"
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
/// - A box that left its larger one is taken out of the candidates and searched for on its own.
/// - When too many have left, the list is made anew, at the cost of one step of the method; when they left all at
///   once, sooner than foreseen, one step is done from scratch first, so that the new list knows how they move.
/// - When lists do not last, no more are made for a while.
/// What is on the list is tested where the boxes lie in the order of the list, so that neighbours share cache lines; a
/// box that is on no list is only looked at. How far ahead boxes are swept is adapted so that making lists and testing
/// what is on them cost about the same. All decisions are made from counts, never from time.
class VerletList {
 public:
  /// Starts a step as BroadPhase::begin. `method` finds the pairs, of all boxes or of the larger ones; `search`
  /// looks in what the method last built, nullptr: it cannot be searched, which is for few boxes.
  std::size_t begin(const BoxArray& boxes, BroadPhase& method, BoxSearch* search);
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
  std::size_t outside() const { return outside_.size(); }
  /// Pairs on the list.
  std::size_t candidates() const { return listed_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t boxes_a_block = 4096;
  static constexpr std::size_t pairs_a_block = 4096;
  static constexpr std::size_t outside_a_block = 64;
  static constexpr std::size_t first_method_stage = 3;               // after: look, decide, enlarge
  static constexpr std::size_t own_stages = first_method_stage + 4;  // and: make room, collect, arrange, cut

  struct Piece {
    std::size_t list, first, last;
  };
  struct Scratch {
    std::array<Pair, pairs_a_block> hits;
    std::vector<std::uint32_t> row;
    std::size_t memory() const { return bytes_of(row); }
  };
  class Overlapping;
  class Collected;
  class Found;

  void look(std::size_t block);
  void collect(std::size_t block);
  void arrange(std::size_t list);
  void cut();
  void place(std::size_t block);
  void claim_places(const std::vector<Pair>& list);
  void decide();
  void enlarge(std::size_t block);
  void adapt();
  float usual_motion() const;
  /// Whether a box that is not outside overlaps `box`.
  bool meets(std::uint32_t other, const Aabb& box) const;
  void search_outside(std::size_t block, PairSink& sink);
  std::size_t size() const { return boxes_->size(); }
  bool too_long() const;
  /// The first of the stages after the method's but its last.
  std::size_t room_stage() const { return first_method_stage + method_stages_ - 1; }
  std::size_t look_blocks() const { return (size() + boxes_a_block - 1) / boxes_a_block; }

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
  BroadPhase* method_ = nullptr;
  BoxSearch* search_ = nullptr;
  std::size_t method_stages_ = 0;
  Mode mode_ = Mode::scratch;
  bool bare_ = false;          // this step is the method's alone, and leaves no trace here
  bool method_begun_ = false;  // in `begin` already
  std::size_t bare_steps_left_ = 0, failures_ = 0;

  PageVector<BoxRecord> past_;  // the boxes of some step before
  bool has_past_ = false;
  std::size_t past_age_ = 0, past_steps_ = 1;  // steps since; the same when it was last replaced
  bool copy_now_ = true;                       // this step replaces it
  BoxArray larger_;
  double steps_ahead_ = 8;
  float usual_motion_ = 0;

  std::vector<std::vector<Pair>> lists_;    // a list a block of the method; of indices, once arranged of places
  PageVector<std::uint32_t> place_, body_;  // a box's place among the records, and back
  PageVector<BoxRecord> records_;           // of this step, those outside empty
  std::atomic<std::uint32_t> places_{0};    // taken
  std::atomic<std::size_t> arranged_{0};    // lists
  std::size_t list_count_ = 0;
  bool list_made_ = false;
  bool too_long_ = false;  // the list of the step before
  std::atomic<std::size_t> blocks_done_{0}, listed_{0}, hits_{0};
  std::vector<Piece> pieces_;
  std::size_t age_ = 0, outside_since_ = 0;
  PairFilter filter_;
  FilterCopy list_filter_;

  std::vector<std::vector<std::uint32_t>> outside_of_block_;
  std::vector<std::uint32_t> outside_;    // ascending
  std::vector<std::uint8_t> is_outside_;  // one a box
  BoxArray outside_boxes_;
  ScratchPool<Scratch> scratch_;
};

}  // namespace tandem
