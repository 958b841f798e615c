// Tolerances of the narrow phase: every threshold below which a difference does not count, with its reason.
#pragma once
#include <limits>

namespace tandem {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
/// The machine epsilon, the distance from 1 to the next double: one operation rounds by at most half of it, relative to
/// its result.
inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Each threshold is defined once; rounding of a few operations is written where it occurs, as a multiple of `epsilon`.
/// "Less:" and "More:" say what a smaller and a larger value would cause. Lengths are relative to the size (the sum of
/// the shapes' diagonals), to the scale (the size plus the distance of the origins) or to what the comment names.
/// Angles are given as sines, which here equal radians, or as squared sines where the name ends in 2.
namespace tolerance {

constexpr double squared(double x) { return x * x; }

// ---- Rounding of sums, products and determinants

/// The rounding of projections onto an axis, summed, relative to the size: 18 epsilon, for some twelve products of
/// rounded axes. Less: a separation along an axis is accepted though it is noise, and touching boxes count as apart.
/// Ten times more: the slow formula is used more often.
inline constexpr double axis_rounding = 4e-15;

/// The margin by which an edge-edge axis must separate better than a face axis, which is the more exact one (relative
/// to the size), and by which one side of a triangle must be nearer to a point than another (relative to the
/// distance): else the side whose direction separates better counts. Less: rounding chooses, and normals jump between
/// equal boxes. More: near ties use the second best of two separations, or of two distances, which is wrong by that.
inline constexpr double tie = 1e-15;

/// The relative rounding of a squared length compared with a squared reach: 4.5 epsilon, for three products and sums.
/// Outside of it the squares decide; within, the square root does. Less: verdict and distance contradict each other at
/// a touch.
inline constexpr double squares_rounding = 1e-15;

/// The outward rounding of an interval so that it contains its exact bounds, relative to the numbers in it: 4.5
/// epsilon. Less: a box of a hierarchy lacks a triangle's corner, and a touch is missed. More costs nothing until boxes
/// grow noticeably.
inline constexpr double outward = 1e-15;

/// The rounding of a determinant of rounded differences, relative to its permanent (the same sum with absolute values):
/// 9 epsilon, where 3.5 are needed (Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997, orient3d). Less: an
/// uncertain sign counts as certain. More: exact arithmetic is used more often.
inline constexpr double permanent_rounding = 2e-15;

/// The rounding of a determinant relative to the cube of the largest difference: 6 x 10 u, u = epsilon / 2, is 6.7e-15.
/// Less and more: as for `permanent_rounding`.
inline constexpr double determinant_rounding = 1e-14;

/// `determinant_rounding` in single precision, u = 2^-24: 6 x 10 u is 3.6e-6.
inline constexpr double determinant_rounding_of_floats = 4e-6;

/// The rounding of a difference of coordinates, of a product of two such differences and of one of three, relative to
/// the largest: a little above 1, 4 and 16 epsilon. They decide on which side of a triangle a point lies; closer cases
/// are computed exactly. Less: a winding number is off by one. More: exact arithmetic is used more often.
inline constexpr double difference_rounding = 2.3e-16;
inline constexpr double area_rounding = 1e-15;
inline constexpr double volume_rounding = 4e-15;

/// The margin of a quick test whose verdict counts, relative to the terms of its sums: a thousand times their rounding,
/// so that no exact analysis is needed. Less than 1e-15: wrong verdicts near touches. More: pairs within the margin are
/// solved in full without need.
inline constexpr double certain = 1e-12;

/// The distance by which a point may lie outside the hull of its points, relative to the size of both shapes: four
/// times 1e-12, the most that qhull's planes and their extension leave. Less: points lie outside their bounding hull.
inline constexpr double outside_of_hull = 4e-12;

/// The allowed difference of two answers for one pair (a verdict and a distance), relative to the sizes and the
/// translation: 450 epsilon; solvers are right to a tenth of it. Less: verdict and sign of the distance contradict each
/// other. More: near touches are solved twice, and gaps of that size get the sign of the verdict.
inline constexpr double undecided = 1e-13;

/// The relative difference of one distance measured between two points and along a normal: 45 epsilon. Less: answers
/// right to rounding are solved again. More: normals off by its square root are accepted.
inline constexpr double same_distance = 1e-14;

/// The largest gap between the bounds of an answer that counts as zero, relative to the scale: 450 epsilon. Less:
/// answers right to rounding get an error bound. More: existing errors are not reported.
inline constexpr double no_gap = 1e-13;

/// The error of a corner after rotation and translation, relative to the size (including the translation). Less: a
/// point lies outside of its plane or box. More: more triangles are tested.
inline constexpr double place_rounding = 1e-13;

/// The length that a translation which separates two meshes has beyond the depth, relative to the sizes: rounding may
/// move a mesh by a third of it (`place_rounding`). Less: meshes moved by the depth still touch. More: two depths that
/// are both within it of the true one differ by more than 1e-12.
inline constexpr double translation_slack = 3e-13;
/// `translation_slack` for rounded shapes, relative to the sizes and the translation between them: the accuracy of
/// their distances.
inline constexpr double rounded_translation_slack = 1e-12;
/// The tilt of a direction towards a perpendicular one, which breaks ties among equally far points: no more than the
/// flatness of a patch.
inline constexpr double tie_lean = 1e-6;

/// The least edge of a voxel, relative to the grid's origin: coordinates are then rounded by 2e-7 of an edge.
/// Less: visible gaps between neighbouring cells. More: usable grids far from the origin are refused.
inline constexpr double cell_of_origin = 1e-9;
/// The distance, in edges of the smallest cell, up to which a contact's point counts as on a surface, so that the
/// cell beyond is examined. Less: rounding puts points inside. More: points near an edge count as on both faces.
inline constexpr double on_cell = 1e-6;

// ---- Single precision and the units of hierarchies

inline constexpr double epsilon_of_floats = std::numeric_limits<float>::epsilon();

/// The rounding of two dot products, each of three products of two rounded numbers and two sums: 10 of 16 units, u =
/// epsilon / 2; in single precision relative to the reach about the centre, in double precision to that about the
/// origin. Less: a support map misses the farthest vertex.
inline constexpr double support_of_floats = 8 * epsilon_of_floats;
inline constexpr double support_of_doubles = 8 * epsilon;
/// A summand in the map's units that keeps the slack of a flat side from being a denormal number.
inline constexpr double clear_of_denormals = 1e-18;

/// Twice the error of the difference of two cosines of normals rounded to single precision (1e-6). Less: the face that
/// points most along a direction is missed. More: more faces are tested in double precision.
inline constexpr double cosine_of_floats = 2e-6;

/// The rounding of heights computed from normals and vertices of 16 bits, relative to the reach: 2 x 2^-16. Less: a
/// deeper face is missed.
inline constexpr double height_of_shorts = 0x1p-15;

/// The rounding of coordinates of two hierarchies in one frame, relative to the summands: 6 units in the last place,
/// 2^-24 each, and a few more for comparisons. Less: intersecting boxes count as apart. More: more boxes are opened.
inline constexpr double box_of_floats = 8e-7;
/// The rounding of a query's box in a hierarchy, relative to the largest coordinate and 2 units of the mesh: as
/// `box_of_floats`.
inline constexpr double query_of_floats = 2e-6;
/// The rounding of a distance from a box or triangle of a hierarchy, in units of the mesh: 7 units in the last place.
inline constexpr double distance_of_floats = 4e-7;
/// The rounding of the height of a corner (in floats) over a plane, in units of the mesh: 7 units in the last place.
/// Less: a slab of a hierarchy lacks a corner, and a nearer triangle is missed. More: more boxes are opened.
inline constexpr double height_of_floats = 4e-7;
/// The rounding of a sum of volumes, each six times, that triangles enclose with a point within their box, relative to
/// the sum of the squares of half the triangles' added width, length and height: 16 of 2^-24 for each product of two
/// sides, which are twice as long. Less: a mesh that is inside out is not recognised. More: the sum is computed in
/// double precision more often.
inline constexpr double volume_rounding_of_floats = 4e-6;
/// The largest deviation of a direction's length from 1: an eigenvector of a zero matrix exceeds it and is no
/// direction.
inline constexpr double no_direction = 1e-3;

/// The distance, in units of the first mesh, up to which two meshes are tested in spite of separate bounding boxes.
/// More costs little.
inline constexpr double whole_boxes = 1e-6;
/// The extent, or padding, in units of a mesh, that counts as zero. Less: coincident centroids are sorted into bins.
inline constexpr double no_extent = 1e-12;

// ---- Rotations that are not quite orthonormal

/// The largest entry of the difference between the identity and the product of a rotation and its transpose: six
/// decimals leave 2 x 3^(1/2) x 5e-7 at most. Less: rotations written with six decimals are refused. More: all that
/// follows here must grow with it.
inline constexpr double skew_allowed = 2e-6;

/// An upper bound on the relative stretch of lengths by such a rotation: its deviation has a norm of up to 3 x 2e-6, of
/// which half counts. Less: a ball inside a body is not inside the rotated body.
inline constexpr double askew = 2 * skew_allowed;

/// `askew` with room for single precision, and for using the transpose as the inverse. An open question: except for
/// that it is the same idea as `askew`.
inline constexpr double askew_in_floats = 1e-5;

/// The deviation up to which a rotation counts as orthonormal to rounding, per entry as for `skew_allowed`: 45 epsilon.
/// Less: each reading orthonormalises again, and bits change.
inline constexpr double orthonormal = 1e-14;

// ---- Directions that count as parallel: sines

/// Sides of triangles: below it a face of the Minkowski difference is narrower than the rounding of the corners. More,
/// as `parallel_edges2`: depths of slivers in meshes change in their last digits. Less: a face's normal is noise.
inline constexpr double parallel_sides2 = squared(1e-13);
/// Edges of polytopes or of their Minkowski difference: 45 epsilon. Less: a cross product that is noise, as the normal
/// of a triangle or an axis of separation. More: boxes rotated by a tiny angle lack an axis that separates.
inline constexpr double parallel_edges2 = squared(1e-14);
/// Segments, axes and circles, whose crossing point divides by it. Less: the crossing of two that are parallel to
/// rounding lies anywhere. More: lines that cross at 1e-11 count as parallel, with an error of that part of their
/// length.
inline constexpr double parallel_lines = 1e-12;
inline constexpr double parallel_lines2 = squared(parallel_lines);
/// Planes whose line of intersection is computed: a squared sine. Less: the line lies anywhere. More: an edge of two
/// faces that are nearly parallel is not searched.
inline constexpr double parallel_planes2 = 1e-20;

/// Edges and sides whose crossing, from squares, keeps half of its digits; below, products are summed without
/// cancellation, or another method is used. Less: digits are lost. More: slower methods more often, the same answers.
inline constexpr double crossing2 = squared(1e-4);
/// `crossing2` where the answer is not verified: a cross product of edges that is accurate to 14 digits.
inline constexpr double clearly_crossing_edges2 = squared(1e-2);
/// Sides of a triangle whose normal is accurate, and segments whose crossing is accurate. It lies between the two
/// above; as all three ask whether a formula is accurate enough, they might be one: an open question.
inline constexpr double slanting2 = squared(1e-3);
/// The ratio of the area of a triangle to its longest side, squared, from which the triangle spans a plane.
inline constexpr double spans_plane2 = squared(1e-6);

/// The angle up to which an edge or face of a box lies in the other box's face (some 5e4 epsilon; boxes solved by their
/// axes alone). Less: one corner represents a flat face, and lies beside the other. More: points off by as much of a
/// side's length.
inline constexpr double in_face = 1e-11;

/// The angle to the contact plane up to which an edge lies in it and carries a patch. Poses that differ by 1e-9 must
/// give the same points, so it is a thousand times that. Less: points come and go as a body rocks. More: depths along
/// the edge are off by that part of its length. (`in_face` is the same idea for witness points: two values.)
inline constexpr double flush = 1e-6;
inline constexpr double flush2 = squared(flush);

/// The difference of cosines up to which two faces count as equally aligned: either may carry the patch, and a rule
/// decides. As cosines change with the square of an angle, so small a number is an angle of 1.4e-6. Less: rounding
/// chooses the face.
inline constexpr double alike_cosines = 1e-12;
/// The cosine to the normal from which a face counts as lying in the contact plane (`flush` for cosines).
inline constexpr double flush_face = 1 - alike_cosines;
/// The cosine from which directions count as equal (4.5e-7 rad): faces of one plane, and a translation that no longer
/// turns. `flush_face` is the same idea: two values.
inline constexpr double one_direction = 1 - 1e-13;
/// The squared change of a unit vector that changes no digit of the other numbers.
inline constexpr double standing_still2 = squared(1e-14);
inline constexpr double stopped_turning2 = 1e-16;

// ---- Points that count as on a feature, and as one

/// The distance by which a point of an edge or face may lie beyond its end, relative to the size: 4,500 epsilon, for a
/// crossing of well-conditioned edges. Less: touching pairs have no witness point and are solved again. More: points
/// off by it.
inline constexpr double on_feature = 1e-12;
inline constexpr double on_feature2 = squared(on_feature);
/// `on_feature` for triangles, whose corners are given, not computed: 45 epsilon.
inline constexpr double over_face = 1e-14;
/// `on_feature2` for round bodies, whose points come from directions accurate to half the digits.
inline constexpr double on_round2 = 1e-16;

/// The distance up to which a point lies in a plane, relative to the size of both meshes: a corner of a mesh that was
/// computed, or stored with nine digits. Less: a flat face is divided, with a patch for each part. More: shallow steps
/// count as flat.
inline constexpr double in_plane = 1e-9;
/// The distance up to which a point lies on an edge and belongs to both triangles, in barycentric coordinates. Less:
/// rays pass between triangles.
inline constexpr double on_edge = 1e-9;
/// The distance up to which points coincide, relative to the size. Less: a curve of intersection stays open where
/// corners meet.
inline constexpr double same_place = 1e-10;

// ---- Depths and lengths that count as alike

/// The difference up to which depths, lengths and positions of corners count as equal, relative to the bodies' size;
/// then a rule decides. Poses that differ by 1e-9 must give the same points, and symmetry makes such values equal:
/// without it rounding would decide for boxes exactly aligned, or resting on a face.
inline constexpr double alike = 4e-9;

/// The difference of depths, relative to the size, up to which points of a mesh's patches are ordered by their
/// features. Less: the order follows rounding. More: of 4 points kept one is shallower. (`alike` is the same idea: two
/// values.)
inline constexpr double same_depth = 1e-6;

/// The additional depth, relative to the size, from which a curved body's deepest point is another one than the corners
/// that represent its circle. (`alike` here would lose a depth of 4e-9.)
inline constexpr double deeper = 1e-9;

/// The rounding of a leaning disc's deepest point: it lies on a grid whose squared step is this over the sine of the
/// angle, so its depth lacks an eighth of it, 1.25e-9 of the radius, less than `alike`. Less: motions of 1e-9 move the
/// point.
inline constexpr double lowest_point_lacks2 = 1e-8;

// ---- Lengths, areas and volumes that are none

/// The length below which the square of a vector may have lost digits by underflow. Lengths of shapes are 1e-30 and
/// more, but two of their points may lie apart by any number, however small.
inline constexpr double shortest_squared = 1e-140;

/// The relative length that rounding may have produced from nothing: 4.5 epsilon. A gap so short has no direction, a
/// capsule so short is a ball. Less: normals are noise. More: lengths of that size lose their axis.
inline constexpr double lost = 1e-15;
inline constexpr double lost2 = squared(lost);
/// `lost2` for three lengths, relative to the sum of their squares, which is at least a third of the square of their
/// sum.
inline constexpr double lost_of_three2 = 3e-30;

/// The relative length below which a difference of points has lost digits by cancellation: it is then made
/// perpendicular to the feature, which is known accurately. Two values: 1 % of lengths known exactly (segments), 1e-4
/// of the scale in a descent, where it costs a product in each step.
inline constexpr double short_gap2 = squared(1e-2);
inline constexpr double short_difference = 1e-4;
/// The length from which the difference of the nearest points of two triangles is their normal, relative to the reach
/// of both meshes: the third value of that idea. Less: normals off by epsilon over this. More: solved again.
inline constexpr double noisy_difference = 1e-5;

/// The widening of the cones of a mesh's normals, radians: more than the rounding of floats and than directions that
/// count as one (`flush`). Less: gaps on flat faces are missed. More: more pairs of triangles are tested.
inline constexpr double cone_slack = 1e-3;

/// The length of the line of centres, or the radius of a ball inside both shapes, that decides nothing, relative to the
/// scale.
inline constexpr double no_centre_line = 1e-12;
inline constexpr double no_centre_line2 = squared(no_centre_line);
/// The radius of a ball inside both shapes that is worth a test, relative to the scale (`no_centre_line` for other
/// searches: two values).
inline constexpr double small_ball = 1e-5;

/// Twice a triangle's area, relative to the square of its longest side, that counts as zero: 45 epsilon, the rounding
/// of its corners. Less: a sliver's normal is noise. More: thin triangles are replaced by their sides.
inline constexpr double no_area = 1e-14;
/// The square of twice an area that counts as zero, m^4: its products with lengths stay in the range of a double.
inline constexpr double least_area2 = squared(1e-60);

/// The thickness, relative to the longest extent, below which a cloud of points is flat, and the distance up to which a
/// vertex lies on a hull's plane: 450 epsilon. Less: qhull fails. More: thin plates have no depth across.
inline constexpr double flat_hull = 1e-13;
/// The relative difference up to which the areas of a mesh and of its hull are equal. Less: finely tessellated bodies
/// are not recognised as convex.
inline constexpr double same_area = 1e-9;
/// Six times the volume of a mesh, relative to the cube of the half diagonal, below which the mesh is inside out.
inline constexpr double inside_out = 1e-12;
/// The volume of a mesh, relative to the cube of its size, below which it has the mass of its box.
inline constexpr double no_volume = 1e-9;
/// The reduction of a hull's inner ball, relative to the reach: a thousand times the error of the hull's planes. Less:
/// pairs near a touch overlap by their balls. More: thin hulls have no inner ball.
inline constexpr double inner_ball_lacks = 1e-9;

/// The distance of points, or the thickness of a line or plane, relative to the scale, below which they span no initial
/// polytope. The second value is for a simplex that may be expanded as it is. Less: faces without a normal. More: more
/// points are tried.
inline constexpr double thin_start = 1e-9;
inline constexpr double thick_start = 1e-6;
/// The area of a face of the Minkowski difference, relative to the scale and its longest side, from which its normal is
/// accurate.
inline constexpr double wide_face = 1e-4;
/// The area of a curve of intersection, relative to its length squared, from which it has a normal.
inline constexpr double sliver_patch = 1e-7;

/// The lengths of directions beyond which (and beyond its inverse) products with them would underflow or overflow in
/// single precision.
inline constexpr double shortest_in_floats = 1e-25;
/// The least squared sine, such that the cube of its root is in the range of a double.
inline constexpr double curvature_in_range = squared(1e-80);
/// Divisors in place of 0, where the quotient is not used or is 0.
inline constexpr double never_zero = 1e-300;
inline constexpr double never_zero_length = 1e-30;
inline constexpr double never_zero_sine = 1e-8;

// ---- Limits of input

/// The shortest length of a shape, metres; its inverse is the longest. Outside, the solvers' products of several
/// lengths, up to tenth powers, would leave the range of a double.
inline constexpr double shortest_length = 1e-30;
/// The longest length of a shape and the farthest coordinate, metres.
inline constexpr double longest_length = 1e30;
/// The shortest normal of a half-space, without unit: its inverse, times any offset, is in the range of a double.
inline constexpr double shortest_normal = 1e-100;

// ---- Accuracy accepted from iterations, and their steps

/// The error, relative to the size, up to which a status is `ok` (or the requested tolerance, if larger). Less: round
/// bodies are `inexact` by amounts of no practical use. More: `ok` promises less than documented.
inline constexpr double accepted_error = 1e-9;

/// The relative gap of bounds at which a descent ends: on polytopes rounding; on round surfaces, which are approached
/// step by step, the last digits would cost more steps than they are worth.
inline constexpr double ends_on_polytopes = 1e-14;
inline constexpr double ends_on_round = 2e-10;
/// The relative gap at which a descent ends because nothing changes.
inline constexpr double ends_at_standstill = 1e-15;

/// The distance of the origin from the surface of the Minkowski difference, relative to the scale, below which a second
/// method checks the verdict: an enclosing simplex may be a flat one that only seems to enclose. It is the root of
/// epsilon, with room, below which squares are noise. Less: wrong verdicts of flat simplices. More: more pairs are
/// solved twice.
inline constexpr double near_surface = 1e-7;
/// The thickness of the Minkowski difference of two polytopes, and so of their overlap, relative to the scale, below
/// which the polytope is expanded in integers: in doubles, planes of such narrow faces are off by rounding over the
/// width times the length (at 1e-6 some 1e-12). Less: depths of needles off by that, and different ones with a warm
/// start. More: more depths are searched twice.
inline constexpr double thin_overlap = 1e-4;
/// The distance to the deepest corner, relative to the scale, up to which the features of corners are searched for a
/// normal.
inline constexpr double near_features = 1e-6;

/// The distances, relative to the size, by which bodies are moved apart and solved again: large enough for a gap with a
/// direction, and small enough that no other feature comes between. The search begins with the first and ends with the
/// last.
inline constexpr double far_apart = 1e-4;
inline constexpr double near_apart = 1e-7;
inline constexpr double least_apart = 1e-9;
/// `least_apart` for round bodies, after a hundredth.
inline constexpr double round_least_apart = 1e-6;

/// The relative difference below which one separating translation is not shorter than another; a contact whose depth is
/// within it has the depth of the pair.
inline constexpr double no_shorter = 1e-9;

/// The end of Newton's method for the point of a line nearest to a box: the squared slope, relative to the squared
/// distance, or the step, relative to the line's half length, that changes no digit (half and two epsilon). Less: 40
/// rounds.
inline constexpr double line_slope2 = 1e-32;
inline constexpr double line_step = 4e-16;
/// The least step of a coordinate in the search for two boxes' nearest points, relative to the size: two epsilon. Less:
/// the search never ends. More: points off by its root times the distance.
inline constexpr double box_points = 5e-16;

/// The step of Newton's method on circles, radians, after which the next one changes no digit.
inline constexpr double newton_end = 1e-7;
/// The slope of a descent that counts as zero, and its curvature, relative to the scale: where h is known only to
/// rounding, they decide.
inline constexpr double descent_flat = 1e-9;
inline constexpr double descent_flat2 = squared(descent_flat);
/// The relative gap from which a descent tests its slope with `descent_flat`.
inline constexpr double descent_end = 1e-6;
/// The least curvature of a descent, relative to the scale: with less, steps would be too long.
inline constexpr double descent_bend = 1e-14;
/// The least angle, radians, by which a descent leaves a disc.
inline constexpr double descent_angle = 1e-9;
/// The accuracy of a descent's bounds and points for an optimum, relative to the scale (between `accepted_error` and
/// rounding).
inline constexpr double descent_accuracy = 1e-10;
/// The gap left by a search along a meridian, relative to the scale, from which expanding a polytope is worth its time.
inline constexpr double search_left = 1e-12;

/// Time of impact: the gap, relative to the bodies' sizes and coordinates, up to which they touch. Less: the approach
/// to a graze never ends, and a point passes between two triangles. More: impacts are early by as much over the closing
/// speed.
inline constexpr double touch = 1e-14;
/// `touch` for rotating bodies, relative to the length of the path: each advance halves the gap instead of squaring it.
/// Less: more advances. More: impacts are early by as much over the closing speed; 1e-9 is promised.
inline constexpr double motion_touch = 1e-10;
/// The last part of a motion that counts as its end, relative to its length.
inline constexpr double end_of_motion = 1e-12;

// ---- Where one method hands over to another: shares and sines of some thousandths

/// The squared sine of the angle of two directions from which formulas with their cross product lose no more than a
/// digit: the normal of two edges, lines, tangents or sides of a triangle, the crossing of two segments or circles of
/// directions. Below, longer formulas take over. Less: digits are lost. More costs only time, but for two lines that
/// nearly touch, whose normal then is the noisy difference of their points.
inline constexpr double clearly_crossing2 = 1e-2;
/// The distance of two boxes along the line of their nearest points, relative to the size, up to which their axes are
/// tested, too: where points nearly touch, their direction is noise. Less: normals of touching boxes from noise. More
/// costs time.
inline constexpr double nearly_touching_boxes = 1e-2;
/// The distance by which bodies that overlap or touch are moved apart to find their contact, relative to the scale.
/// Less: the direction is noise. More: curved surfaces are met elsewhere, and more rounds are needed to return.
inline constexpr double moved_apart = 1e-2;
/// The distance of polytopes, relative to the scale, from which a ray is not tried first: where it leaves the surface
/// may be far from the nearest face. The answer is verified in both cases; only the time differs.
inline constexpr double far_from_surface = 1e-3;
/// The sine of a disc's tilt up to which its deepest point is rounded to a grid, so that small changes of the pose do
/// not move it: above, 1e-9 moves it by less than 1e-6.
inline constexpr double steady_lean = 1e-3;
/// The ratio of width to length of a contact patch up to which it counts as an edge of two points. Less: four points on
/// a strip, of which two carry nothing. More: two points for a face that rocks across.
inline constexpr double thin_patch = 5e-3;
/// The least turn of a normal towards another one, as a share of their angle, with which it will reach it. Less: more
/// rounds without effect.
inline constexpr double least_turn = 1e-2;
/// The ratio of the area of a mesh's contact patch to the square of its curve's length from which its area vector is a
/// direction, where corners lie inside. Less: noise as the normal of a wide patch.
inline constexpr double wide_patch = 1e-3;
/// The ratio of twice the area of a triangle to its longest side's square from which `flush` is a small part of its
/// angles.
inline constexpr double sliver_in_cone = 2e-3;
/// The widening of a cone of normals, of a cosine: it contains faces that lie flush.
inline constexpr double cone_spare = 1e-3;
/// The length of a translation, as a share of the first one found, below which no shorter translations of meshes are
/// searched.
inline constexpr double least_reach = 1e-2;
/// The last step of a climb to a point deep in two meshes, as a share of the first. Less: steps without effect.
inline constexpr double last_climb = 5e-3;
/// The distance beyond the ends of an arc, relative to its length, up to which a minimum found from within belongs to
/// it.
inline constexpr double arc_ends = 1e-2;
/// The sine of the angle between a circle of directions and a minimum up to which the minimum lies on it. More: one
/// beside it, as a disc's axis, hides one on it. Less: minima are found twice.
inline constexpr double on_circle = 1e-12;
/// The length of an arc of directions, radians, up to which a descent from it may pass a narrow minimum.
inline constexpr double narrow_arc = 1e-3;
/// The sine of the angle between two axes of revolution up to which two bodies count as nearly symmetric about one.
/// More: a wider bound on the remaining error. Less: a polytope is expanded, which takes a hundred times as long.
inline constexpr double leaning_axes = 1e-3;
/// The length of a unit vector's part perpendicular to an axis from which one subtraction makes it perpendicular.
inline constexpr double clearly_off_axis = 1e-3;

/// The accuracy requested from libccd and FCL, in metres, as both require. Less: more iterations.
inline constexpr double peer_accuracy = 1e-10;
/// The largest deviation of the length of their normals from 1.
inline constexpr double peer_normal = 1e-6;

// ---- Factors near 1

/// Enlarges a bound computed in single precision from few summands: more than their rounding, 1e-6. Less: rounding may
/// take from the bound. More: more candidates are tested in double precision.
inline constexpr double bound_in_floats = 1.001;
/// The same for one quotient, whose rounding is 1e-7: a margin in the units of a mesh.
inline constexpr double margin_in_floats = 1.00001;
/// Below this share of the squared sum of their radii, of the squared distance between their centres, two inner balls
/// overlap clearly. More: rounding decides. Less: the answer is the same by the full test.
inline constexpr double balls_overlap2 = 0.99;
/// Cosine within which a face's normal is at a known minimum of the depth (1.1 degrees). More: the minimum is searched
/// for again. Less: one beside it is missed.
inline constexpr double at_minimum = 0.9998;
/// Share of a permitted step that is taken, so that rounding leaves its end within what is permitted.
inline constexpr double within_reach = 0.999;
/// Share of a known length below which a shorter translation is searched for; a smaller gain ends a search.
inline constexpr double worth_shortening = 0.999;

}  // namespace tolerance

}  // namespace tandem
