#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {

/// What every piece of work of one step cost on one thread (ns), in the order in which a single thread does them.
struct MeasuredStep {
  struct Stage {
    double open_ns = 0;  ///< before its blocks, on one thread
    std::vector<double> blocks;
  };
  struct Tile {
    double ns = 0;
    std::uint64_t pairs = 0;  ///< emitted
  };
  /// Some pairs in a row that were narrowed together, in StepForm::ordered with the copying of their answers.
  struct Piece {
    double ns = 0;
    std::uint64_t pairs = 0;
    bool heavy = false;
  };

  StepForm form = StepForm::caller;
  double begin_ns = 0;        ///< before the first stage, on the caller
  std::vector<Stage> before;  ///< up to the tiles: boxes, then the broad phase's preparation
  double open_tiles_ns = 0;
  std::vector<Tile> tiles;
  std::vector<Stage> order;  ///< that put the pairs in order before they are narrowed; not in StepForm::overlapped
  double open_narrow_ns = 0;
  std::vector<Piece> pieces;  ///< in the pairs' order: that of the tiles, or the one made
  std::vector<Stage> after;   ///< that join the answers

  /// Narrow phase of the pairs [first, end) that are heavy or not; spread evenly within each piece.
  double narrow_ns(double first, double end, bool heavy) const;
  std::uint64_t pairs() const { return first_pairs_.back(); }
  /// The piece that holds a pair, counted from 0; of one behind the last pair the number of pieces.
  std::size_t piece_of(double pair) const;
  double first_pair(std::size_t piece) const { return static_cast<double>(first_pairs_[piece]); }
  bool has_heavy() const { return costliest_ns_ > 0; }
  double costliest_ns() const { return costliest_ns_; }  ///< of the heavy ones; 0: there are none
  double work_ns() const;
  std::size_t tasks() const;

  friend MeasuredStep read_step(const std::vector<Timeline::Slice>& slices, StepForm form);
  friend MeasuredStep typical_step(std::vector<MeasuredStep> runs);

 private:
  void index();
  std::vector<double*> times();

  std::vector<std::uint64_t> first_pairs_ = {0};  // of each piece, and the end
  std::vector<double> light_until_ = {0};         // of each piece and the end: narrow phase of the light ones before
  double costliest_ns_ = 0;
};

/// From the slices of one step of the sequential executor in this form; throws std::invalid_argument where they are of
/// a step in another one.
MeasuredStep read_step(const std::vector<Timeline::Slice>& slices, StepForm form);

/// The median time of every piece over several runs of one step, as what disturbs a run hits other pieces each time;
/// together they take the median of the runs' sums. Throws std::invalid_argument where there is none, or where two
/// differ in their work.
MeasuredStep typical_step(std::vector<MeasuredStep> runs);

/// One step in every form.
struct MeasuredForms {
  MeasuredStep caller, overlapped, ordered;
  const MeasuredStep& in(StepForm form) const {
    return form == StepForm::caller ? caller : form == StepForm::ordered ? ordered : overlapped;
  }
};

}  // namespace tandem
