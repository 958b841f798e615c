#pragma once
#include <limits>

namespace tandem {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
/// From 1 to the next double: one operation rounds by half of it, relative to its result.
inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// The numbers below which a difference does not count, each once; what rounding does to a few operations is written at
/// its place as a multiple of `epsilon`. Lengths are relative: to the size (the diagonals of the shapes, added), to the
/// scale (that, and the distance of the origins) or to what a comment says. Angles are given as sines, so that they
/// are radians, or as their squares where the name ends in 2.
namespace tolerance {

constexpr double squared(double x) { return x * x; }

// ---- Rounding of sums, products and determinants

/// Of an axis: what the sums of its projections may lose together, relative to the size: 18 epsilon, for some twelve
/// products of rounded axes. Less: an axis' separation is believed where it is noise, and touching boxes part by it;
/// ten times more: the slow formula is taken more often.
inline constexpr double axis_rounding = 4e-15;

/// By how much, relative to the size, an edges' axis must separate better than a face's, or the vector to an edge be
/// shorter than to a corner: the simpler formula is the more exact one. Less: rounding chooses, and normals jump
/// between equal boxes. More: near ties get the second best of two separations, wrong by that.
inline constexpr double tie = 1e-15;

/// Of a squared length and of a squared reach, relative: 4.5 epsilon, for three products and sums. Outside this the
/// squares decide; within, the root does. Less: verdict and distance contradict each other at a touch.
inline constexpr double squares_rounding = 1e-15;

/// What an interval is widened by so that it holds what it bounds, relative to the numbers in it: 4.5 epsilon. Less: a
/// box of a hierarchy lacks a triangle's corner, and a touch is missed. More costs nothing until boxes show it.
inline constexpr double outward = 1e-15;

/// Of a determinant of rounded differences, relative to its permanent (the same of absolute values): 9 epsilon, where
/// 3.5 are needed (Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997, orient3d). Less: a sign is called
/// certain that is not. More: exact arithmetic is asked more often.
inline constexpr double permanent_rounding = 2e-15;

/// Of a determinant, relative to the cube of the largest difference: 6 x 10 u, u = epsilon / 2, is 6.7e-15. As above.
inline constexpr double determinant_rounding = 1e-14;

/// Of a determinant in single precision, u = 2^-24: 6 x 10 u is 3.6e-6.
inline constexpr double determinant_rounding_of_floats = 4e-6;

/// Of a difference of coordinates, a product of two such and one of three, relative to the largest: a little above 1, 4
/// and 16 epsilon. They decide on which side of a triangle a point lies; what is nearer is computed exactly. Less: a
/// winding number is off by one. More: exact arithmetic is asked more often.
inline constexpr double difference_rounding = 2.3e-16;
inline constexpr double area_rounding = 1e-15;
inline constexpr double volume_rounding = 4e-15;

/// What a quick test has to be beyond for its verdict to stand, relative to the terms of its sums: a thousand times
/// what they lose, so that no exact count is needed. Less than 1e-15: wrong verdicts near touches; more: pairs within
/// that are solved in full though they need not be.
inline constexpr double certain = 1e-12;

/// How far a point may lie outside the hull of its points, relative to the size of both shapes: four times 1e-12, the
/// most that qhull's planes and their extension leave. Less: a point is outside of what bounds it.
inline constexpr double outside_of_hull = 4e-12;

/// What two answers to one question (a verdict and a distance), relative to the sizes and the translation, may differ
/// by: 450 epsilon, solvers are right to a tenth of it. Less: verdict and sign of the distance contradict each other.
/// More: near touches are solved twice, and gaps of that size get the sign of the verdict.
inline constexpr double undecided = 1e-13;

/// One distance measured between two points and along a normal, relative to it: 45 epsilon. Less: answers right to
/// rounding are solved again. More: normals off by its root are taken.
inline constexpr double same_distance = 1e-14;

/// A gap between the bounds of an answer that is none, relative to the scale: 450 epsilon. Less: answers right to
/// rounding are given an error. More: errors that answers have are not told.
inline constexpr double no_gap = 1e-13;

/// Of places: what turning and shifting a corner may move it by, relative to the size (with the translation). Ten times
/// less was taken where the nearest of two meshes is looked for (`place_rounding_of_nearest`); which is needed is open.
/// Less: a plane or box is passed by what lies in it. More: more triangles are looked at.
inline constexpr double place_rounding = 1e-13;
inline constexpr double place_rounding_of_nearest = 1e-14;

/// What a translation that separates two meshes is longer than the depth, relative to the sizes: rounding may move a
/// mesh by a third of it (`place_rounding`). Less: moved by the depth, they still meet. More: two depths that are both
/// within it of the true one differ by more than 1e-12.
inline constexpr double translation_slack = 3e-13;
/// `translation_slack` of shapes with rounding, relative to the sizes and the translation between them: their distances
/// are right to this.
inline constexpr double rounded_translation_slack = 1e-12;
/// How much a direction leans to one that is square to it, to choose the same one of points that are as far: no more
/// than a patch is flat.
inline constexpr double tie_lean = 1e-6;

// ---- Single precision and the units of hierarchies

inline constexpr double epsilon_of_floats = std::numeric_limits<float>::epsilon();

/// Two dot products, each of three products of two rounded numbers and two sums: 10 of 16 units, u = epsilon / 2, in
/// single precision relative to the reach about the middle, in double precision to that about the origin. Less: a
/// support map leaves the farthest vertex out.
inline constexpr double support_of_floats = 8 * epsilon_of_floats;
inline constexpr double support_of_doubles = 8 * epsilon;
/// In the map's units; keeps the slack of a flat side from being a denormal number.
inline constexpr double clear_of_denormals = 1e-18;

/// Two cosines of normals rounded to single precision are off by less than 1e-6 together; twice that. Less: a face that
/// looks most along a direction is left out. More: more faces are looked at in double precision.
inline constexpr double cosine_of_floats = 2e-6;

/// Heights from normals and vertices of 16 bits: relative to the reach, 2 x 2^-16 with rounding. Less: a face that lies
/// deeper is passed over.
inline constexpr double height_of_shorts = 0x1p-15;

/// Coordinates of two hierarchies in one frame, relative to what is added: 6 units in the last place, 2^-24 each, and a
/// few more for comparing. Less: boxes that meet are parted. More: more boxes are opened.
inline constexpr double box_of_floats = 8e-7;
/// A query's box against a hierarchy, relative to the largest coordinate and 2 units of the mesh: as `box_of_floats`.
inline constexpr double query_of_floats = 2e-6;
/// A distance from a box or triangle of a hierarchy, in units of the mesh: 7 units in the last place.
inline constexpr double distance_of_floats = 4e-7;
/// The height of a corner that was rounded to floats over a plane, in units of the mesh: 7 units in the last place.
/// Less: a slab of a hierarchy lacks a corner, and a nearer triangle is missed. More: more boxes are opened.
inline constexpr double height_of_floats = 4e-7;
/// Of a sum of volumes that triangles and a point within their box enclose, each six times, relative to the sum of the
/// squares of half the triangles' width, length and height added: 16 of 2^-24 for each product of two sides, which are
/// twice as long. Less: a mesh that is inside out is taken for one that is not. More: doubles are asked more often.
inline constexpr double volume_rounding_of_floats = 4e-6;
/// A direction whose length is off from 1 by more is none: what an eigenvector of nothing is.
inline constexpr double no_direction = 1e-3;

/// What whole meshes may be apart by, in units of the first, and be looked at all the same. More costs little.
inline constexpr double whole_boxes = 1e-6;
/// An extent, or a pad, in units of a mesh that stands for none. Less: centroids in one place are sorted into bins.
inline constexpr double no_extent = 1e-12;

// ---- Rotations that are not quite orthonormal

/// How far the product of a rotation and its transpose may be from the identity, in each entry: six decimals leave
/// 2 x 3^(1/2) x 5e-7 at most. Less: rotations written so are refused. More: all that follows here must grow with it.
inline constexpr double skew_allowed = 2e-6;

/// More than such a rotation stretches a length by, relative: what it is off by has a norm of up to 3 x 2e-6, of which
/// half shows. Less: a ball inside a body is not inside the body as it is turned.
inline constexpr double askew = 2 * skew_allowed;

/// `askew` with room for single precision, and where the inverse is taken for the transpose. An open question: it is
/// one idea with `askew` but for that.
inline constexpr double askew_in_floats = 1e-5;
/// And about a place, relative to the size: less than the two above, without a reason that is known.
inline constexpr double askew_place = 1e-6;

/// A rotation is orthonormal to rounding, in each entry of what skew_allowed compares: 45 epsilon. Less: each reading
/// orthonormalizes again, and bits change.
inline constexpr double orthonormal = 1e-14;

// ---- Directions that count as parallel: sines

/// Edges of boxes, and segments along them: what the entries of rotations are rounded by, 4.5 epsilon. Less: an axis
/// that is noise. More: boxes turned by a hair lack an axis that separates.
/// Four values, this and the next three, for edges whose product is noise: an open question, they could be one.
inline constexpr double parallel_axes2 = squared(1e-15);
/// Sides of triangles: a face of the difference is then narrower than rounding of the corners.
inline constexpr double parallel_sides2 = squared(1e-13);
/// Edges between vertices of polytopes or of their difference; of a triangle: it has no normal; of a tetrahedron: flat.
inline constexpr double parallel_edges2 = squared(1e-14);
/// Segments, axes and circles, whose crossing divides by it. Less: the crossing of two that are parallel to rounding
/// lies anywhere. More: those that cross at 1e-11 are taken side by side, off by as much of their length.
inline constexpr double parallel_lines = 1e-12;
inline constexpr double parallel_lines2 = squared(parallel_lines);
/// Planes, of which the line that they share is wanted.
inline constexpr double parallel_planes2 = 1e-20;

/// Edges and sides whose crossing from squares keeps half of its digits: below, products are summed without
/// cancellation, or another method is taken. Less: digits are lost. More: slower methods more often, the same answers.
inline constexpr double crossing2 = squared(1e-4);
/// `crossing2` where the answer is not looked at again: a product of edges that is trusted, to 14 digits.
inline constexpr double clearly_crossing_edges2 = squared(1e-2);
/// Sides of a triangle with an exact normal, and segments whose crossing is exact. Between the two above, as all three
/// ask whether a formula is exact enough: an open question.
inline constexpr double slanting2 = squared(1e-3);
/// Of an area to the longest side: a triangle that spans a plane.
inline constexpr double spans_plane2 = squared(1e-6);

/// An edge or face that leans by less lies in the other's face (boxes, by their axes alone: some 5e4 epsilon). Less: of
/// flat faces a corner stands for all, and lies beside the other. More: points off by as much of a side's length.
inline constexpr double in_face = 1e-11;

/// An edge within this angle of the contact plane lies in it, and carries a patch. Poses that differ by 1e-9 must give
/// the same points, so a thousand times that. Less: points come and go as a body rocks. More: depths along the edge
/// are off by that part of its length. (`in_face` is the same idea for witness points: two values.)
inline constexpr double flush = 1e-6;
inline constexpr double flush2 = squared(flush);

/// Cosines of faces that differ by less are one: either may carry the patch, and a rule decides. As cosines change by
/// the square of an angle, so small a number is flat to 1.4e-6. Less: rounding picks the face.
inline constexpr double alike_cosines = 1e-12;
/// A face whose cosine to the normal is larger is as good as in the contact plane (`flush` for cosines).
inline constexpr double flush_face = 1 - alike_cosines;
/// Cosine of directions that are one: faces of one plane (4.5e-7 rad), and a translation that no longer turns (1.4e-7).
/// With `flush_face` three values for one idea: an open question.
inline constexpr double one_direction = 1 - 1e-13;
inline constexpr double no_turn = 1 - 1e-14;
/// The change of a unit vector, squared, that moves no digit of the other numbers.
inline constexpr double standing_still2 = squared(1e-14);
inline constexpr double stopped_turning2 = 1e-16;

// ---- Points that count as on a feature, and as one

/// A point of an edge or face may lie beyond its end by this, relative to the size: 4,500 epsilon, for a crossing of
/// well-conditioned edges. Less: touching pairs have no witness point and are solved again. More: points off by it.
inline constexpr double on_feature = 1e-12;
inline constexpr double on_feature2 = squared(on_feature);
/// `on_feature` of triangles, whose corners are not computed but given: 45 epsilon.
inline constexpr double over_face = 1e-14;
/// And of round bodies, whose points come from directions good to half the digits: squared.
inline constexpr double on_round2 = 1e-16;

/// A point this near a plane lies in it, relative to the size of both meshes: a corner of a mesh that was computed, or
/// stored with nine digits. Less: a flat face falls into parts, with a patch each. More: shallow steps count as flat.
inline constexpr double in_plane = 1e-9;
/// A point this near an edge, in barycentric coordinates, belongs to both sides. Less: rays pass between triangles.
inline constexpr double on_edge = 1e-9;
/// Points nearer than this times the size are one. Less: a curve of crossings stays open where corners meet.
inline constexpr double same_place = 1e-10;

// ---- Depths and lengths that count as alike

/// Poses that differ by 1e-9 must give the same points. So what a patch's symmetry makes equal (depths, lengths, places
/// of corners) counts as equal within this, relative to the bodies' size, and a rule of its own decides: a threshold in
/// the middle of boxes exactly aligned, or resting on a face, would be crossed by rounding.
inline constexpr double alike = 4e-9;

/// Points of patches of a mesh with this depth, relative to the size, are ordered by their features. Less: the order
/// follows rounding. More: of 4 points kept a shallower one. (`alike` is the same idea: two values.)
inline constexpr double same_depth = 1e-6;

/// A curved body is deeper than the corners that stand for its circle by more than this, relative to its size: another
/// point. (`alike` here, too, would let 4e-9 of depth go.)
inline constexpr double deeper = 1e-9;

/// A leaning disc's deepest point stays on a grid whose step squared is this over the sine of the angle: the depth
/// there lacks an eighth of it, 1.25e-9 of the radius, less than `alike`. Less: motions of 1e-9 move the point.
inline constexpr double lowest_point_lacks2 = 1e-8;

/// A depth of two meshes that is none, relative to the size. Less: noise has a translation that separates.
inline constexpr double no_depth = 1e-12;

// ---- Lengths, areas and volumes that are none

/// The squares of vectors shorter than this may have lost digits, or all of them. Lengths of shapes are 1e-30 and more,
/// but two points of theirs may lie apart by any number, however small.
inline constexpr double shortest_squared = 1e-140;

/// A length relative to what it is reckoned with, of which rounding leaves nothing: 4.5 epsilon. A gap so short has no
/// direction, a capsule so short is a ball. Less: normals are noise. More: what is as long loses its axis.
inline constexpr double lost = 1e-15;
inline constexpr double lost2 = squared(lost);
/// Its square for three lengths by the sum of their squares, which is at least a third of their sum's square.
inline constexpr double lost_of_three2 = 3e-30;

/// A difference of points has lost digits by cancellation, relative to what they are reckoned with: it is made square
/// to the feature, which is known with all. Two values: 1 % of lengths known exactly (segments), 1e-4 of the scale in a
/// descent, where it costs a product each step.
inline constexpr double short_gap2 = squared(1e-2);
inline constexpr double short_difference = 1e-4;
/// The difference of the nearest points of two triangles is their normal where it is longer than this, relative to the
/// reach of both meshes: the third value of that idea. Less: normals off by epsilon over this. More: solved again.
inline constexpr double noisy_difference = 1e-5;

/// Cones of a mesh's normals are wider by this, radians: more than floats are off by, and than the directions that
/// count as one (`flush`). Less: gaps on flat faces are passed over. More: more pairs of triangles are looked at.
inline constexpr double cone_slack = 1e-3;

/// A line of centres, or a ball inside both, relative to the scale, that says nothing.
inline constexpr double no_centre_line = 1e-12;
inline constexpr double no_centre_line2 = squared(no_centre_line);
/// A ball inside both, relative to the scale, that is worth a test (`no_centre_line` for other searches: two values).
inline constexpr double small_ball = 1e-5;

/// Twice a triangle's area, relative to its longest side squared: 45 epsilon, what its corners are rounded by. Less: a
/// sliver's normal is noise. More: thin triangles are taken for their sides.
inline constexpr double no_area = 1e-14;
/// And its square in metres to the fourth, so that its products with lengths stay in the range of a double.
inline constexpr double least_area2 = squared(1e-60);

/// A cloud of points thinner than this, relative to its longest extent, is flat, and a vertex this near a hull's plane
/// lies on it: 450 epsilon. Less: qhull fails. More: thin plates have no depth across.
inline constexpr double flat_hull = 1e-13;
/// Areas of a mesh and of its hull, relative, that are one. Less: finely cut bodies are not known as convex.
inline constexpr double same_area = 1e-9;
/// Six times the volume, relative to the half diagonal's cube: a mesh with less is wound inside out.
inline constexpr double inside_out = 1e-12;
/// Volume relative to the size's cube, below which a mesh has the mass of its box.
inline constexpr double no_volume = 1e-9;
/// What the ball inside a hull is smaller by than its planes say, relative to the reach: a thousand times what they are
/// off by themselves. Less: pairs near a touch overlap by their balls. More: thin hulls have none.
inline constexpr double inner_ball_lacks = 1e-9;

/// A polytope to begin with: points this near each other, a line or a plane, relative to the scale, span nothing. The
/// second is for a simplex that may be expanded as it is. Less: faces without a normal. More: more points are tried.
inline constexpr double thin_start = 1e-9;
inline constexpr double thick_start = 1e-6;
/// Area of a face of the difference relative to the scale and its longest side, for its normal to be exact.
inline constexpr double wide_face = 1e-4;
/// Area of a curve of crossings, relative to its length squared, that has a normal.
inline constexpr double sliver_patch = 1e-7;

/// Lengths of directions beyond which (and beyond its inverse) single precision would lose the products with them.
inline constexpr double shortest_in_floats = 1e-25;
/// A sine squared, so that its root's cube is in the range of a double.
inline constexpr double curvature_in_range = squared(1e-80);
/// Divisors instead of 0, where the quotient is not used or is 0.
inline constexpr double never_zero = 1e-300;
inline constexpr double never_zero_length = 1e-30;
inline constexpr double never_zero_sine = 1e-8;

// ---- Limits of input

/// The shortest length of a shape, metres; its inverse is the longest. Outside, the solvers' products of several
/// lengths would leave the range of a double: tenth powers of both are in it.
inline constexpr double shortest_length = 1e-30;
/// The longest length of a shape and the farthest coordinate, metres.
inline constexpr double longest_length = 1e30;
/// Of a half-space's normal, which has no unit: its inverse is in the range of a double, times any offset.
inline constexpr double shortest_normal = 1e-100;

// ---- Accuracy accepted from iterations, and their steps

/// A status is `ok` where the error is no larger, relative to the size, or than the tolerance asked for. Less: round
/// bodies are `inexact` for what no use sees. More: `ok` says less than the documentation does.
inline constexpr double accepted_error = 1e-9;

/// The relative gap of bounds where a descent ends: polytopes to rounding; round surfaces, which are approached step by
/// step, where the last digits cost more steps than they are worth.
inline constexpr double ends_on_polytopes = 1e-14;
inline constexpr double ends_on_round = 2e-10;
/// And of a descent that ends when nothing changes.
inline constexpr double ends_at_standstill = 1e-15;

/// Origins nearer than this to the difference's surface, relative to the scale, need a second opinion: an enclosing
/// simplex may be a flat one that only seems to. Root of epsilon, with room: such are noise in squares. Less: wrong
/// verdicts of flat simplices; more: more pairs are solved twice.
inline constexpr double near_surface = 1e-7;
/// Two polytopes whose difference, and so their overlap, is thinner than this, relative to the scale: planes of faces
/// that narrow are off by rounding over the width times the length (at 1e-6 some 1e-12), so the features of both are
/// asked. Less: depths of needles off by that, other ones with a warm start. More: more depths are searched twice.
inline constexpr double thin_overlap = 1e-4;
/// Two polytopes hardly touch: the vector between them is noise (`near_surface` is the same idea: two values).
inline constexpr double hardly_touching = 1e-9;
/// How near, relative to the scale, corners must lie to the deepest for their features to be searched for a normal.
inline constexpr double near_features = 1e-6;

/// Bodies are moved apart by these, relative to the size, and looked at again: far enough that a gap has a direction,
/// and near enough that nothing comes between. The first is where to begin, the last where to end.
inline constexpr double far_apart = 1e-4;
inline constexpr double near_apart = 1e-7;
inline constexpr double least_apart = 1e-9;
/// `least_apart` of round bodies, after a hundredth.
inline constexpr double round_least_apart = 1e-6;

/// A translation out that is shorter by less than this part is no shorter; a contact's depth within it is the depth.
inline constexpr double no_shorter = 1e-9;

/// Newton's method for the nearest point of a line to a box ends where the squared slope, relative to the squared
/// distance, or the step, relative to the line's half length, changes no digit: half and two epsilon. Less: 40 rounds.
inline constexpr double line_slope2 = 1e-32;
inline constexpr double line_step = 4e-16;
/// Two boxes' nearest points: how far a coordinate must want to move, relative to the size, two epsilon. Less: it never
/// ends. More: points off by the root of it times the distance.
inline constexpr double box_points = 5e-16;

/// Newton's method on circles, radians: the step after so small a one changes no digit.
inline constexpr double newton_end = 1e-7;
/// A descent's slope that is none, and its bend, relative to the scale: where h is known to rounding, only they tell.
inline constexpr double descent_flat = 1e-9;
inline constexpr double descent_flat2 = squared(descent_flat);
/// From where a descent looks at its slope for that.
inline constexpr double descent_end = 1e-6;
/// A descent's curvature, relative to the scale, at least: longer steps would lead nowhere.
inline constexpr double descent_bend = 1e-14;
/// The least angle, radians, that a descent leaves a disc by.
inline constexpr double descent_angle = 1e-9;
/// A descent's bounds and points, relative to the scale, for an optimum (between `accepted_error` and rounding).
inline constexpr double descent_accuracy = 1e-10;
/// What a search by a meridian must leave open, relative to the scale, for a polytope to be worth its time.
inline constexpr double search_left = 1e-12;

/// Time of impact: bodies that are no farther apart, relative to their sizes and coordinates, touch. Less: creeping
/// towards a graze never ends, a point passes between two triangles. More: early by as much over the speed of closing.
inline constexpr double touch = 1e-14;
/// `touch` of bodies that turn, relative to the length of the path: advances halve what is left rather than square it.
/// Less: more of them. More: early by as much over the speed of closing; 1e-9 is promised.
inline constexpr double motion_touch = 1e-10;
/// The last bits of the end of a motion belong to it, relative to its length.
inline constexpr double end_of_motion = 1e-12;

// ---- Where one method hands over to another: shares and sines of some thousandths

/// Squared sine of the angle of two edges of boxes, below which the short formula of their axis loses digits, and more
/// where the rotation is off from orthonormal: the axis is projected in full. Less: separations off by 1e-14 of the
/// size. More costs time alone.
inline constexpr double slow_edges2 = 1e-2;
/// Squared sine from which two segments clearly cross and have a formula without cases. Less: it loses digits. More:
/// the formula with cases is taken more often.
inline constexpr double clearly_crossing2 = 1e-2;
/// Squared sine from which the cross product of two lines, or of tangents of circles, gives the normal; else the
/// difference of the points does. Less: noise of the one. More: noise of the other, where they nearly touch.
inline constexpr double square_lines2 = 1e-2;
/// Squared sine of a triangle's corner from which its two sides give its normal; else the two shorter ones do.
inline constexpr double wide_corner2 = 1e-2;
/// Boxes no farther apart, relative to the size, along the line of their nearest points are asked by their axes, too:
/// of points that nearly touch the direction may be any. Less: normals of touching boxes from noise. More costs time.
inline constexpr double nearly_touching_boxes = 1e-2;
/// How far bodies that overlap, or touch, are moved apart to find where they touch, relative to the scale. Less: the
/// direction is noise. More: what is curved is reached elsewhere, and rounds are needed to come back.
inline constexpr double moved_apart = 1e-2;
/// Polytopes farther apart, relative to the scale, than this are not asked by a ray first: what ends on the surface by
/// a ray may be far from the nearest face then. Either way the answer is checked; only time differs.
inline constexpr double far_from_surface = 1e-3;
/// Sine by which a disc leans up to which the place of its deepest point is put on a grid, so that it stays when the
/// pose changes a little: from there 1e-9 moves it by less than 1e-6.
inline constexpr double steady_lean = 1e-3;
/// Width of a contact patch to its length, up to which it counts as an edge of two points. Less: four points of a
/// strip, of which two carry nothing. More: two points for a face that rocks across.
inline constexpr double thin_patch = 5e-3;
/// A normal that turns towards another by a smaller share of the angle does not get there. Less: more rounds, for
/// nothing.
inline constexpr double least_turn = 1e-2;
/// Area of a mesh's contact patch to the square of its curve's length from which its area vector is a direction, where
/// corners lie inside. Less: noise of a wide patch for its normal.
inline constexpr double wide_patch = 1e-3;
/// Twice the area of a triangle over its longest side's square, from which `flush` is a small part of its angles.
inline constexpr double sliver_in_cone = 2e-3;
/// What a cone of normals is wider than the normals in it, of a cosine: faces that lie flush are in it.
inline constexpr double cone_spare = 1e-3;
/// Translations of meshes shorter than this share of what the first one needs are not searched for.
inline constexpr double least_reach = 1e-2;
/// A climb to a place deep in two meshes ends with a step of this share of the first. Less: steps that find nothing.
inline constexpr double last_climb = 5e-3;
/// How far beyond an arc's ends, of its length, a minimum found from within still belongs to it.
inline constexpr double arc_ends = 1e-2;
/// Length of an arc of directions, radians, up to which a descent from it may lead past a narrow minimum.
inline constexpr double narrow_arc = 1e-3;
/// Sine of the angle between two axes of revolution up to which two bodies are nearly the same all around one. More: a
/// wider bound on what is left; less: a polytope is expanded, which takes a hundred times as long.
inline constexpr double leaning_axes = 1e-3;
/// Length of a unit vector's share off an axis from which it is square to it after one subtraction.
inline constexpr double clearly_off_axis = 1e-3;

/// What libccd and FCL are asked for: in metres, as both take it. Less: more iterations.
inline constexpr double peer_accuracy = 1e-10;
/// How far from 1 the length of a normal of theirs may be.
inline constexpr double peer_normal = 1e-6;

}  // namespace tolerance
}  // namespace tandem
