// Minima of h on circles of directions, where one body's support has a kink.
#pragma once
#include "round/face_reach.h"
#include "round/minima.h"

namespace tandem {

/// The least of h on a circle, one where body `which` has a kink or another through its centre.
void search_circle(Minima& m, int which, const Circle& circle, bool kink);

/// The least of h on the arcs between the normals of a polytope's faces, where two of its corners reach as far.
void search_face_arcs(Minima& m, int which, const FaceReach& reach);

}  // namespace tandem
