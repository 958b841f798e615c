// The nearest points of two meshes.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <new>
#include <type_traits>

#include "meshes/traversal/hierarchy.h"
#include "meshes/traversal/nearest_kernel.h"
#include "meshes/traversal/touching_faces.h"
#include "meshes/traversal/triangle_pair.h"
#include "shapes/posed_mesh.h"
#include "shapes/work_meter.h"
#include "tandem/narrowphase/options.h"
#include "tolerances.h"
#include "triangles/triangle_kernel.h"

namespace tandem {

/// The nearest points found so far, and their distance.
struct Nearest {
  double distance = infinity;
  Vec3 on_a = Vec3::Zero(), on_b = Vec3::Zero();
  /// Takes square roots only for candidates: squares are rounded, by less than the margin.
  void take(const Vec3& p, const Vec3& q) {
    const double square = (p - q).squaredNorm();
    if (!may_take(square)) return;
    if (const double d = std::sqrt(square); d < distance) distance = d, square_ = square_within(d), on_a = p, on_b = q;
  }
  bool may_take(double square) const { return !(square > square_); }
  /// Leaves out pairs farther than a distance already found.
  void leave_out_beyond(double known) { square_ = std::min(square_, square_within(known)); }

 private:
  static double square_within(double d) { return d * d * (1 + 8 * epsilon); }
  double square_ = infinity;
};

/// A triangle by its longest side and the height on it: projections on its plane keep their position along the side,
/// and a sliver's normal, which rounding may turn anywhere, is not used.
struct TriangleFrame {
  Vec3 from, side, slant, height;
  double side2 = 0, height2 = 0;

  TriangleFrame() = default;
  explicit TriangleFrame(const Corners& t);
};

/// A triangle with the data for finding its nearest points to others.
struct PlacedTriangle {
  Corners corner;
  EdgeColumns edges;
  TriangleFrame frame;

  PlacedTriangle() = default;
  explicit PlacedTriangle(const Corners& t);
  Vec3 edge(std::size_t i) const { return {edges.edge[0][i], edges.edge[1][i], edges.edge[2][i]}; }
};

/// Takes the nearest points of two triangles that do not intersect.
void triangles_nearest(const PlacedTriangle& p, const PlacedTriangle& q, Nearest& best);
void triangles_nearest(const Corners& p, const Corners& q, Nearest& best);

/// A triangle of a posed mesh.
struct FaceOf {
  Corners corners;  ///< in the mesh's frame
  Pose pose;
  bool of_solid;  ///< its normal points out of a solid
};

/// The direction from A to B at nearest points of two triangles that do not intersect, unit. Where they are so near
/// that rounding would turn it, that of the triangles' features; of two in one plane that in which solids have their
/// outside. `reach`: of both meshes.
Vec3 direction_between(const Nearest& near, const FaceOf& a, const FaceOf& b, double reach,
                       const NarrowPhaseOptions& options);

/// The error of corners of both, metres.
double rounding_of_corners(const MeshModel& a, const MeshModel& b, const Vec3& between);

/// The number of pairs of triangles up to which their direction is found together; of more, each has its own.
inline constexpr std::size_t most_touching = std::size_t{1} << 14;

/// The direction that separates all pairs of triangles that are as near as the nearest to `rounding`, if there is one,
/// else, if rounding makes the gap, that of the shortest translation off all faces touched inside; else `own`, that
/// between the nearest, or the normal of such a face if it differs by rounding.
Vec3 direction_of(TouchingFaces& near, double gap, double rounding, const Vec3& own);

/// The nearest points of surfaces that do not intersect, by branch and bound; relative to A's translation, in world
/// axes.
class NearestSearch {
 public:
  NearestSearch(const Posed& a, const Posed& b, const WorkLimit* limit);

  /// An infinite distance if none is nearer than `cutoff` (metres).
  Nearest operator()(double cutoff = infinity);

  /// Visits every pair of triangles [of A, of B] at most `within` apart, with its nearest points; pairs for which
  /// `meet` returns true have distance 0 and no points. False: visit(pair, nearest) returned false. `progress`, if not
  /// empty, gets the fraction done, increasing. `leave_out`, if not empty: selects pairs of places that are skipped
  /// with all below them.
  using Meet = std::function<bool(std::uint32_t, std::uint32_t)>;
  using Visit = std::function<bool(const TrianglePair&, const Nearest&)>;
  using LeaveOut = std::function<bool(const Item&)>;
  bool each_within(double within, const Meet& meet, const Visit& visit, const std::function<void(double)>& progress,
                   const LeaveOut& leave_out = {});

  /// The direction from A to B at the result's points, in world axes (`direction_of`). Where it is that of another pair
  /// of triangles, as near to rounding, `points` become that pair's; else they stay.
  Vec3 normal(const NarrowPhaseOptions& options, Nearest& points);

 private:
  bool goes_down_a(const Item& at) const;
  void solve(std::uint32_t triangle_a, std::uint32_t triangle_b);
  /// Pairs of triangles as near as the nearest, to rounding: two boxes have at most 144.
  struct Tie {
    TrianglePair pair;
    double distance;
  };
  static constexpr std::size_t most_ties = 144;
  void add_tie(const TrianglePair& pair, double distance);
  bool has_all_ties() const { return least_left_out_ > best_.distance + rounding_; }
  /// True if the direction separates them all by the distance, to rounding.
  bool separates_ties(const Vec3& n) const;
  /// Takes points and direction of the first tie, by index, whose direction separates all; false if none of a few does.
  /// Points beside each other, of one pair or of neighbours, are equally near, but most directions between such points
  /// lean over the triangles.
  bool take_separating_tie(const NarrowPhaseOptions& options, Nearest& points, Vec3& n);
  /// A triangle in world axes relative to A's translation, kept, since most pairs have one in common with the pair
  /// before.
  struct LastTriangle {
    std::uint32_t triangle = 0xffffffffu;
    PlacedTriangle placed;
  };
  const PlacedTriangle& placed_of_a(std::uint32_t triangle);
  const PlacedTriangle& placed_of_b(std::uint32_t triangle);
  /// Lower bounds (metres) for the children of the larger of two places; which of the two that is, and its node. A
  /// bound beyond `within` (metres) may be below the best possible one.
  struct Children {
    bool of_a;
    std::uint32_t node;
    std::array<double, mesh_lanes> bound;
    Vec3 aligned_mid;
  };
  Children bounds_of_children(const Item& at, double within);
  /// A place of one mesh in the other's frame, kept, since most consecutive pairs have one of the two in common.
  struct SeenVolume {
    const MeshView& view;
    std::uint32_t ref;
    NearVolume volume;
    explicit SeenVolume(const MeshView& v) : view(v), ref(whole), volume(v.volume(whole)) {}
    const NearVolume& at(std::uint32_t place) {
      if (place != ref) ::new (&volume) NearVolume(view.volume(place)), ref = place;  // constructed in place
      return volume;
    }
    static_assert(std::is_trivially_destructible_v<NearVolume>);
  };

  std::array<Tie, most_ties> ties_;
  std::size_t tie_count_ = 0;
  double least_left_out_ = infinity;  ///< the distance of the nearest pair for which there was no room
  const MeshModel &a_, &b_;
  const Mat3 &turn_a_, &turn_b_;
  const Vec3 between_;
  const MeshView a_by_b_, b_by_a_;
  SeenVolume seen_a_{a_by_b_}, seen_b_{b_by_a_};
  LastTriangle last_a_, last_b_;
  const double rounding_, slack_;  ///< of corners, of the bounds; metres
  WorkMeter meter_;
  Nearest best_;
  TrianglePair nearest_{};  ///< the triangles of `best_`, of A and of B
  /// From A to B, unit, once there is a pair: in world axes, A's and B's.
  Vec3 normal_ = Vec3::Zero(), normal_a_ = Vec3::Zero(), normal_b_ = Vec3::Zero();
};

}  // namespace tandem
