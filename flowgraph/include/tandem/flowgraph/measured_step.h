// The measured costs of a step, as input of a simulated schedule.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {

/// The cost of every piece of work of one step on one thread (ns), in the order in which a single thread does the
/// pieces: the input of a simulated schedule.
struct MeasuredStep {
  struct Stage {
    double open_ns = 0;  ///< before its blocks, on one thread
    std::vector<double> blocks;
  };
  struct Tile {
    double ns = 0;
    std::uint64_t pairs = 0;  ///< pairs emitted
  };
  /// Consecutive pairs that were narrowed together; in StepForm::ordered their time includes the copying of their
  /// answers.
  struct Piece {
    double ns = 0;
    std::uint64_t pairs = 0;
    bool heavy = false;
  };

  StepForm form = StepForm::caller;
  double begin_ns = 0;        ///< before the first stage, on the caller
  std::vector<Stage> before;  ///< stages before the tiles: boxes, then the broad phase's preparation
  double open_tiles_ns = 0;
  std::vector<Tile> tiles;
  std::vector<Stage> order;  ///< stages that sort the pairs before they are narrowed; empty in StepForm::overlapped
  double open_narrow_ns = 0;
  std::vector<Piece> pieces;  ///< in the pairs' order: that of the tiles, or the sorted one
  std::vector<Stage> after;   ///< stages that join the answers

  /// Time of the narrow phase of the pairs [first, end), heavy ones or the others; a piece's time is spread evenly over
  /// its pairs.
  double narrow_ns(double first, double end, bool heavy) const;
  std::uint64_t pairs() const { return first_pairs_.back(); }
  /// The piece that holds a pair, counted from 0; for a pair behind the last one, the number of pieces.
  std::size_t piece_of(double pair) const;
  double first_pair(std::size_t piece) const { return static_cast<double>(first_pairs_[piece]); }
  bool has_heavy() const { return costliest_ns_ > 0; }
  double costliest_ns() const { return costliest_ns_; }  ///< of the costliest piece of heavy pairs; 0: there is none
  double work_ns() const;
  std::size_t tasks() const;

  friend MeasuredStep read_step(const std::vector<Timeline::Slice>& slices, StepForm form);
  friend MeasuredStep typical_step(std::vector<MeasuredStep> runs);

 private:
  void index();
  std::vector<double*> times();

  std::vector<std::uint64_t> first_pairs_ = {0};  // first pair of each piece, and the end
  std::vector<double> light_until_ = {0};         // for each piece and the end: time of the light pairs before it
  double costliest_ns_ = 0;
};

/// The costs from the recorded slices of one step of the sequential executor in this form; throws std::invalid_argument
/// where the slices are of a step in another form.
MeasuredStep read_step(const std::vector<Timeline::Slice>& slices, StepForm form);

/// The median cost of every piece over several runs of one step, since what disturbs a run hits other pieces each time;
/// the pieces are scaled so that their sum is the median of the runs' sums. Throws std::invalid_argument if there is no
/// run, or if two differ in their work.
MeasuredStep typical_step(std::vector<MeasuredStep> runs);

/// The costs of one step in every form.
struct MeasuredForms {
  MeasuredStep caller, overlapped, ordered;
  const MeasuredStep& in(StepForm form) const {
    return form == StepForm::caller ? caller : form == StepForm::ordered ? ordered : overlapped;
  }
};

}  // namespace tandem
