// The depth of two small polytopes by the faces of their difference A - B.
#pragma once
#include "shapes/minkowski_difference.h"

namespace tandem {

/// The least depth of two overlapping polytopes, each a box or a hull of few vertices: over all directions in which the
/// support of A - B can be least. These are the normals of the faces of A - B: the faces of both, and products of an
/// edge of A and one of B. The former are bounded by their supports in single precision; for the latter each edge of A
/// represents an arc of directions, from one face's normal to the other's (Gregorius 2013, the Gauss map), on which the
/// supports of B at its ends say how little lies between: few arcs have to be followed. Much cheaper than an expanding
/// polytope where that would need many vertices: when deep.
///
/// False where it does not apply, or rounding leaves doubt; the answer then is untouched. The origin must lie inside
/// A - B, farther than rounding.
bool depth_by_faces(const MinkowskiDifference& d, LocalAnswer& answer);

}  // namespace tandem
