#pragma once
#include <cstddef>
#include <cstdint>

namespace tandem {

/// Rectangular faces over each other, a pair a column: the incident one's centre and half edges as the reference one
/// sees them along the normal: where in its plane that leaves it (two coordinates), then the height over its box's
/// centre. Depths are measured, and points put midway, along this normal, which has a slant against the reference
/// face's, and slips along it.
struct RectanglePairRows {
  static constexpr std::size_t most = 96;
  alignas(64) double centre[3][most], edge1[3][most], edge2[3][most];
  double half1[most], half2[most];                 ///< lengths of the two half edges
  double half_u[most], half_w[most];               ///< half sizes of the reference face
  double top[most];                                ///< its height
  double slant[most], slip_u[most], slip_w[most];  ///< cosine; 1, 0, 0 where it is the face's own
  double distance[most], near[most];               ///< signed distance of the two boxes; what counts as equal
  double name[most];                               ///< of their contacts, but for the point; a whole number
};

/// Points of the patches, in the order of their names: the incident face's four corners, the reference face's four,
/// then crossings of edges: the first reference edge's with the four incident ones, and so on.
struct RectanglePatchRows {
  static constexpr std::size_t most = RectanglePairRows::most, points = 24;
  alignas(64) double touching[most];  ///< bit i: point i is one of the patch's; a whole number
  double u[points][most], w[points][most], depth[points][most];  ///< of those alone
};

/// Numbers of columns that `clip_rectangles` reads beyond those it was given; any that are valid will do.
constexpr std::size_t columns_beyond = 7;

/// Clips the incident faces of `count` columns, named by `columns`, as `append_box_manifold` does, a pair a lane, with
/// the same bits. Patches are in columns of their own, one after the other.
void clip_rectangles(const RectanglePairRows& pairs, const std::int64_t* columns, std::size_t count, double margin,
                     RectanglePatchRows& found);

}  // namespace tandem
