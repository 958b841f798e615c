// Boxes of links in many poses, at a few nanoseconds each, and which of them are near one another or a body.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "queries/pose_list.h"
#include "tandem/broadphase/box_array.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// A box in the link's frame, rounded by a radius: exactly a sphere, capsule or box, and a bound of other shapes.
class LinkBox {
 public:
  LinkBox() = default;  ///< a point
  /// The limit may end the building of a mesh's hull (WorkStopped).
  explicit LinkBox(const Shape& link, const WorkLimit* limit = nullptr);
  LinkBox(const LinkBox& link, double margin) : LinkBox(link) { radius += margin; }  ///< grown by it, metres

  double radius = 0;
  Vec3 centre = Vec3::Zero(), half = Vec3::Zero();

  /// The distance of its farthest point from the origin of its frame.
  double reach() const { return half.norm() + centre.norm() + radius; }
};

/// A link's poses in single precision, in blocks of four: the rotation's columns and the translation, or rows of both.
struct alignas(64) PoseNumbers {
  static constexpr std::size_t most_lanes = 16;  ///< floats of a vector
  static constexpr std::size_t count = 64;       ///< poses, a multiple of that
  std::array<std::array<float, 4 * count>, 3> groups;
  bool by_rows;
};

/// A body's box in its own frame with the body's pose, and its box in world axes.
struct PlacedBox {
  PlacedBox(const LinkBox& own, const Pose& pose, const Aabb& world);

  LinkBox own;
  std::array<float, 12> pose;  ///< rotation by columns, translation
  Aabb world;
};

/// True if a separating axis of the two posed boxes is found; false: not known. For a single pair: most are decided by
/// the first axes.
bool known_apart(const LinkBox& a, const Pose& pose_a, const LinkBox& b, const Pose& pose_b);

/// A link in 64 configurations: its converted poses, and the index of its first box.
struct LinkInPart {
  const LinkBox* box;
  const PoseNumbers* numbers;
  std::size_t at;
};

/// The destination of links' boxes in 64 configurations: boxes[link * stride + at ...], and their union per link in
/// `swept`.
struct LinkBoxScratch {
  BoxArray* boxes;
  std::size_t stride, at;
  Aabb* swept;
  PoseNumbers* numbers;
};

/// Boxes of links in many configurations. Poses and boxes are in single precision: boxes in world axes are enlarged,
/// and gaps reduced, by a bound on the rounding errors.
class LinkBoxes {
 public:
  /// Configurations `first` to first + count - 1, poses row by row; those that follow are prefetched. Returns false if
  /// require_valid may refuse a pose, or the last row of a matrix is not 0, 0, 0, 1. Throws WorkStopped where the limit
  /// is reached. The links' boxes must outlive the calls below.
  bool take(std::span<const LinkBox> links, const PoseList& poses, std::size_t first, std::size_t count,
            const WorkLimit& limit);

  /// A box in world axes, and the union of a link's boxes in all configurations.
  Aabb box(std::size_t link, std::size_t k) const { return boxes_[place(link, k)]; }
  const Aabb& swept(std::size_t link) const { return swept_[link]; }

  /// All boxes, and the index of a link's box. Those between two links' boxes are unused: they may be NaN.
  const BoxArray& boxes() const { return boxes_; }
  std::size_t places() const { return links_.size() * stride_; }
  std::size_t place(std::size_t link, std::size_t k) const { return link * stride_ + k; }

  /// The queries below take 64 configurations at a time.
  std::size_t parts() const { return (count_ + PoseNumbers::count - 1) / PoseNumbers::count; }
  /// Bit k: the posed boxes may touch in configuration 64 * part + k.
  std::uint64_t meeting(std::size_t part, std::size_t link, std::size_t other) const;
  std::uint64_t meeting(std::size_t part, std::size_t link, const PlacedBox& body) const;
  /// At most the distance of the two boxes, turned as they are; negative where they may touch.
  double gap(std::size_t k, std::size_t link, const PlacedBox& body) const;

  /// Bytes beside itself.
  std::size_t memory() const {
    return boxes_.memory() + swept_.capacity() * sizeof(Aabb) + numbers_.capacity() * sizeof(PoseNumbers);
  }

 private:
  LinkInPart in_part(std::size_t part, std::size_t link) const;

  std::span<const LinkBox> links_;
  std::size_t count_ = 0, stride_ = 0;  // stride: from one link's boxes to the next's
  BoxArray boxes_;
  std::vector<Aabb> swept_;
  std::vector<PoseNumbers> numbers_;  // of each link in 64 configurations, then in the next
};

}  // namespace tandem
