#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "shapes/work_meter.h"
#include "tandem/narrowphase/answer.h"
#include "tolerances.h"

namespace tandem {

/// A direction across the axis (unit) that no shape has of itself, nor any two of its corners in common: what is alike
/// along others is told apart along it.
Vec3 uncommon(const Vec3& axis);

/// At most 4 of the contacts from `first` on, all of about one normal: corners of a patch as wide as any, and the
/// deepest; by feature. What is alike but for rounding (`size` is that of the bodies) is told apart by where it lies,
/// not by its place in the list.
void keep_widest(std::vector<Contact>& contacts, std::size_t first, double size);

/// Gathers the contacts of a mesh's triangles with one convex shape into patches: those of about one normal, at most
/// four, that span the patch.
class PatchCollector {
 public:
  /// `limit` ends the work of `finish` (WorkStopped).
  explicit PatchCollector(double size, const WorkLimit* limit) : size_(size), meter_(limit) {}
  PatchCollector(const PatchCollector&) = delete;
  PatchCollector& operator=(const PatchCollector&) = delete;

  /// Of triangle t, without those deeper than a limit; their normals point from the mesh.
  void add(std::uint32_t t, std::span<const Contact> contacts, double deepest = infinity);

  /// Appends what is kept, by feature. Patches of a solid whose normals oppose each other are two sides of one wall
  /// that the shape with this centre has gone through: the far one does not push.
  void finish(const Vec3& centre, bool solid, std::vector<Contact>& out);

 private:
  double size_;
  WorkMeter meter_;
  alignas(std::max_align_t) std::array<std::byte, 16384> usual_;  // enough but for very many triangles
  std::pmr::monotonic_buffer_resource memory_{usual_.data(), usual_.size()};
  std::pmr::vector<Contact> all_{&memory_};
};

}  // namespace tandem
