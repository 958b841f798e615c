// The regions of ranks, and the ranks whose regions a box overlaps.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "communicator.h"
#include "tandem/narrowphase/pose.h"

struct Zoltan_Struct;

namespace tandem::mpi {

/// A body's box, rounded outward to floats, as for the broad phase: pairs that it finds have boxes here that overlap,
/// too.
struct FloatBox {
  std::array<float, 3> lo{}, hi{};

  bool holds(const FloatBox& other) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (!(lo[i] <= other.lo[i] && other.hi[i] <= hi[i])) return false;
    return true;
  }
};

/// The points in (lo, hi] on every axis.
struct Region {
  std::array<double, 3> lo{}, hi{};

  bool holds(const std::array<double, 3>& point) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (!(lo[i] < point[i] && point[i] <= hi[i])) return false;
    return true;
  }
  bool holds(const FloatBox& box) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (!(lo[i] < double{box.lo[i]} && double{box.hi[i]} <= hi[i])) return false;
    return true;
  }
};

/// Space divided into a region for each rank by Zoltan's recursive coordinate bisection (Berger and Bokhari 1987).
/// Every rank knows all cuts, so it can tell the owner of a point without a message.
class Regions {
 public:
  /// Collective. All of space belongs to rank 0 until the first cut.
  explicit Regions(const Communicator& communicator);
  ~Regions();
  Regions(const Regions&) = delete;
  Regions& operator=(const Regions&) = delete;

  /// Collective: cuts anew so that the weights (>= 0) of all ranks' points are evenly distributed; there must be at
  /// least one point. Returns false, and changes nothing, if Zoltan fails.
  bool cut(std::span<const Vec3> points, std::span<const float> weights);
  /// Restores the cuts before the last.
  void take_back();
  bool is_cut() const { return cut_ != nullptr; }

  /// The rank whose region holds a point. From any thread.
  int owner(const std::array<double, 3>& point) const;
  /// True if this rank owns the point. From any thread.
  bool holds(const std::array<double, 3>& point) const {
    return is_box_ ? own_.holds(point) : owner(point) == communicator_.rank();
  }
  /// True only if the whole box is this rank's (it may be false although it is). From any thread.
  bool holds(const FloatBox& box) const { return is_box_ && own_.holds(box); }
  /// This rank's region, or an empty one: no point in it is another rank's.
  Region own() const;
  /// The ranks whose regions a box reaches into, by rank. Valid until the next call.
  std::span<const int> reached(const FloatBox& box) const;

 private:
  void read_cut();

  const Communicator& communicator_;
  Zoltan_Struct *cut_ = nullptr, *before_ = nullptr;
  Region own_;
  bool is_box_ = true;  // own_ is this rank's region
  mutable std::vector<int> ranks_;
};

}  // namespace tandem::mpi
