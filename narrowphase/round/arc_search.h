// Minima of h on circles of directions, where one body's support has a kink.
#pragma once
#include "round/face_reach.h"
#include "round/minima.h"

namespace tandem {

/// Finds the minimum of h on a circle of directions, either one where body `which` has a kink or one through its
/// centre.
void search_circle(Minima& m, int which, const Circle& circle, bool kink);

/// Finds the minimum of h on the arcs between the normals of a polytope's adjacent faces, on which two of its vertices
/// are equally far.
void search_face_arcs(Minima& m, int which, const FaceReach& reach);

}  // namespace tandem
