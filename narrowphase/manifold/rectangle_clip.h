// Rectangular faces clipped by each other, a pair a lane.
#pragma once
#include <cstddef>
#include <cstdint>

namespace tandem {

/// Pairs of overlapping rectangular faces, a pair a column: the incident face's centre and half edges in the reference
/// face's frame, as two coordinates in its plane, to which points are projected along the normal, and the height above
/// its box's centre. Depths are measured along the normal, and points lie midway along it; `slant` and `slip` are its
/// components relative to the reference face.
struct RectanglePairRows {
  static constexpr std::size_t most = 96;
  alignas(64) double centre[3][most], edge1[3][most], edge2[3][most];
  double half1[most], half2[most];                 ///< lengths of the two half edges
  double half_u[most], half_w[most];               ///< half sizes of the reference face
  double top[most];                                ///< its height
  double slant[most], slip_u[most], slip_w[most];  ///< cosine; 1, 0, 0 where the normal is the face's own
  /// Signed distance of the two boxes; the difference that counts as equal.
  double distance[most], near[most];
  double name[most];  ///< the name of their contacts without the point; an integer
};

/// The points of the patches, in the order of their names: the incident face's four corners, the reference face's four,
/// then the crossings of edges: the first reference edge with the four incident ones, and so on.
struct RectanglePatchRows {
  static constexpr std::size_t most = RectanglePairRows::most, points = 24;
  alignas(64) double touching[most];                             ///< bit i: point i belongs to the patch; an integer
  double u[points][most], w[points][most], depth[points][most];  ///< only for these
};

/// The number of columns that `clip_rectangles` reads beyond the given ones; any valid ones will do.
constexpr std::size_t columns_beyond = 7;

/// Clips the incident faces of `count` columns, named by `columns`, as `append_box_manifold` does, a pair a lane, with
/// the same bits. Patches are in columns of their own, one after the other.
void clip_rectangles(const RectanglePairRows& pairs, const std::int64_t* columns, std::size_t count, double margin,
                     RectanglePatchRows& found);

}  // namespace tandem
