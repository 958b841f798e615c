// Contacts of a mesh with a convex shape, gathered into patches.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "shapes/lent_memory.h"
#include "shapes/work_meter.h"
#include "tandem/narrowphase/answer.h"
#include "tolerances.h"

namespace tandem {

/// A unit vector perpendicular to the axis, in a direction that no shape has by itself, nor any two of its corners:
/// breaks ties between points equal along other directions.
Vec3 tie_break_direction(const Vec3& axis);

/// Keeps at most 4 of the contacts from `first` on, all of about one normal: corners of a patch as wide as any, and the
/// deepest; sorted by feature. Contacts equal to rounding (`size`: of the bodies) are ordered by position, not by their
/// place in the list. `meter`: counts the work, if not null.
void keep_widest(std::vector<Contact>& contacts, std::size_t first, double size, WorkMeter* meter = nullptr);

/// Features of contacts: the number of a triangle or cell times this, plus the place among its contacts; of more, the
/// last ones share a number.
inline constexpr std::uint32_t contacts_of_one = 64;

/// Gathers the contacts of a mesh's triangles with one convex shape into patches: groups of about one normal, of which
/// at most four that span the patch are kept.
class PatchCollector {
 public:
  /// Uses of the options: `limit`, which ends the work of `finish` (WorkStopped), and `memory`.
  PatchCollector(double size, const NarrowPhaseOptions& options)
      : size_(size), meter_(options.limit), memory_(usual_.data(), usual_.size(), lent_memory(options)) {}
  PatchCollector(const PatchCollector&) = delete;
  PatchCollector& operator=(const PatchCollector&) = delete;

  /// Adds the contacts of triangle t; their normals point from the mesh.
  void add(std::uint32_t t, std::span<const Contact> contacts);

  /// Appends the kept contacts no deeper than `deepest`, sorted by feature. Patches of a solid whose normals oppose
  /// each other are two sides of one thin solid part that the shape with this centre has passed through: the far side
  /// does not push.
  void finish(const Vec3& centre, bool solid, std::vector<Contact>& out, double deepest = infinity);

 private:
  struct Point {
    Vec3 at;
    double depth;
  };
  /// Consecutive contacts of a triangle with exactly the same normal: points from `first` to the next run's.
  struct Run {
    Vec3 normal;
    std::uint32_t triangle, first;
    bool goes_on;             ///< the run before is of the same triangle
    std::uint32_t patch = 0;  ///< the patch that it belongs to
  };
  struct Place;
  struct Patch;
  template <class Value>
  using List = std::pmr::vector<Value>;

  List<Place> places_of(double deepest);
  List<Patch> find_patches(const List<Place>& places);
  List<Place> by_patch(const List<Place>& places, List<Patch>& patches);
  void leave_out_far(const Vec3& centre, List<Patch>& patches);
  void join_sides(const List<Place>& places, List<Patch>& patches);
  void append_widest(const List<Place>& places, const List<Patch>& patches, std::vector<Contact>& out);

  double size_;
  WorkMeter meter_;
  alignas(std::max_align_t) std::array<std::byte, 24576> usual_;  // enough except for very many triangles
  std::pmr::monotonic_buffer_resource memory_;
  List<Run> runs_{&memory_};
  List<Point> points_{&memory_};
};

}  // namespace tandem
