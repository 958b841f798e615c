// Penetration depth of two shapes, with bounds.
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

/// Bounds on the penetration depth. If Request::distance computes the exact depth (Status::ok), both bounds are it. For
/// two shapes that are each a mesh, a box or a hull, at least one of them solid, the bounds come from a search over
/// translations: `upper` is the shortest translation found that separates, and `lower` is proven by boxes of
/// translations that cover all shorter ones; for each box a point of A remains deeper in B, and in A, than the
/// translations in the box differ (Lipschitz optimisation: Piyavskii 1972). Boxes near the zero translation come first,
/// so `lower` rises as long as the search goes on. Other pairs have the bounds of Request::distance.
///
/// The translation may lead anywhere: out of a thin solid on either side, or into a hole. The inside of a shape is:
/// - for a convex or round shape, and a solid mesh: the volume that its surface encloses; for a hollow solid with thin
///   walls the material of the walls, not the cavity;
/// - for a mesh that is not solid, closed or not, and for a triangle: nothing. Only its triangles count: a convex or
///   round shape, or a solid, collides if a triangle touches it or lies in it, and is separated on either side, also
///   when the mesh encloses it;
/// - for two surfaces: nothing. They collide where triangles intersect, and a surface that has passed through the other
///   completely is separated.
/// An open mesh is refused as a solid; no surface is guessed to close it.
///
/// The result depends only on the arguments; exchanged shapes give the same bounds. Throws std::invalid_argument for
/// half-spaces that no translation separates, and for an invalid option. The limit does not end the final verification
/// of the translation, usually a single verdict.
DepthBounds penetration_depth(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                              const DepthOptions& options = {});

}  // namespace tandem
