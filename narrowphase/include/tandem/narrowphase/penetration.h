#pragma once
#include <cstddef>

#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Accuracy and limits of the search for a depth.
struct DepthOptions {
  /// The wanted gap of the bounds: `upper` at most this much larger than `lower`, relative to `upper`, [0, 1].
  double gap = 0.05;
  /// The most boxes of translations that are examined: more time, better bounds. 0: only the bounds known without a
  /// search.
  std::size_t most_boxes = 20'000;
  /// Ends the search (work_limit.h): the bounds reached by then are returned (`incomplete`); WorkStopped is thrown only
  /// if the limit is reached before the distance's bounds are known. Null: none.
  const WorkLimit* limit = nullptr;
};

/// Bounds on the depth of two shapes in each other: the length of the shortest translation of B after which they no
/// longer collide.
struct DepthBounds {
  bool collide = false;             ///< false: they are apart, all else is 0
  double lower = 0;                 ///< metres: after every shorter translation they still collide
  double upper = 0;                 ///< metres: the length of `translation`; at least `lower`
  Vec3 translation = Vec3::Zero();  ///< of B in the world: after it they do not collide, as was tested exactly
  std::size_t boxes = 0;            ///< boxes of translations that were examined
  bool incomplete = false;          ///< the limit ended the search: the bounds hold, but could have been better
};

/// Bounds on the depth. Where Request::distance knows the depth (Status::ok), it is that. Else, of two
/// shapes that are each a mesh, a box or a hull, one of them solid, the translations are searched: `upper` is the
/// shortest that was found to separate, and `lower` is proven by boxes of translations that cover all that are shorter,
/// each of them shown to leave a point of A deeper in B, and in A, than the translations in the box differ (Lipschitz
/// optimisation: Piyavskii 1972). The boxes nearest to none come first, so `lower` rises as long as the search goes on.
/// Of other pairs the bounds are those of Request::distance.
///
/// Where the translation leads is not asked: out of the side of a wall that was come in by or that of the other, or
/// into a hole. What an inside is, of each shape:
/// - a convex or round shape, and a solid mesh: all that its surface encloses; of a solid with thin walls the walls,
///   not the hollow;
/// - a mesh that is no solid, closed or not, and a triangle: none. Only its triangles count: a convex or round shape,
///   or a solid, collides where one touches it or lies in it, and is apart on either side and within what it goes
///   round;
/// - of two surfaces neither: they collide where triangles meet, and what has come through altogether is apart.
/// A mesh that is not closed is refused as a solid, and nothing is guessed where it would be one.
///
/// Depends on nothing but the arguments; exchanged shapes give the same bounds. Throws
/// std::invalid_argument for half-spaces that no translation separates or a bad option. The last test of the
/// translation, mostly one yes or no, is not ended by the limit.
DepthBounds penetration_depth(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                              const DepthOptions& options = {});

}  // namespace tandem
