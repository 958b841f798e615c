#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tolerances.h"

namespace tandem {

/// Do the two collide with B moved by `move` (world axes)? Fills in the pairs of triangles that meet there, unless they
/// are not asked for (nullptr).
using MovedPairs = std::function<bool(const Vec3& move, std::vector<std::array<std::uint32_t, 2>>* pairs)>;

/// What was found of the shortest translation of B that parts two meshes.
struct WayOut {
  double certain = 0;        ///< no shorter one does
  double length = infinity;  ///< one this long does, along the normal
  Vec3 normal = Vec3::UnitZ();
  Vec3 point = Vec3::Zero();  ///< midway between points that are last to part, relative to A's translation
};

/// The ways out of two meshes whose surfaces cross. An edge that goes through a flat face of the other mesh still does
/// moved a little, until one of its ends comes to the face's plane or the crossing to the face's border: a wall that
/// holds for all translations but long ones. The shortest translation beyond all such walls is a way out if nothing
/// else is there, and no shorter one is than the shortest beyond those that hold so far.
class WaysOut {
 public:
  WaysOut(const Posed& a, const Posed& b, MovedPairs meet);
  ~WaysOut();

  /// Does a translation that long, along a direction (unit), part them, and one a little longer, too? Between two faces
  /// that fit each other there is room for rounding only.
  bool is_out(const Vec3& direction, double length) const;

  /// Looks for a way shorter than `out.length`, beyond the walls about `pairs`, which meet, and those met on the way.
  void leave_walls(std::span<const std::array<std::uint32_t, 2>> pairs, WayOut& out);

  /// Looks for a way along a direction (unit) shorter than the one that is known.
  void attempt(const Vec3& direction, WayOut& out);

  /// The shortest way beyond all that contacts push, if it is free and shorter than the one that is known.
  void attempt(std::span<const Contact> contacts, WayOut& out);

  /// Makes the way that is known shorter, down to one that nothing near it is shorter than.
  void shorten(WayOut& out);

  /// What of the walls about the end of the way that is known makes certain of its length.
  void confirm(WayOut& out);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tandem
