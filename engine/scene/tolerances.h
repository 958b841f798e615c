// Tolerances of the engine, each defined once. Those shared with the narrow phase are in narrowphase/tolerances.h.
// "Less:" and "More:" say what a smaller and a larger value would cause.
#pragma once

namespace tandem::tolerance {

/// The largest deviation of the norm of a quaternion in a file from 1: six digits leave 1e-6. Less: quaternions written
/// with six digits are refused.
inline constexpr double quaternion_norm = 1e-6;
/// The permitted quaternions, for messages.
inline constexpr const char* quaternion_range = "four numbers [w, x, y, z] of norm 1 within 1e-6";

/// An upper bound on the relative stretch of a body's motion by rotations that are orthonormal only to 2e-6: the narrow
/// phase's `askew`, which is private to it. Less: a contact is kept that a fast body has left.
inline constexpr double motion_stretch = 4e-6;
/// The largest option of a response, and the largest component of gravity, m/s^2: the narrow phase's longest length,
/// which is private to it. More: velocities whose sums and products are not finite.
inline constexpr double largest_of_response = 1e30;

/// The rounding of a position after a motion, relative to the numbers in it: 18 epsilon. Less: a contact is kept that a
/// slow body has left.
inline constexpr double motion_rounding = 4e-15;
/// What a shape adds to the gap up to which a time of impact counts it and another one as touching, relative to its
/// size and to its path: the narrow phase's `touch` and `motion_touch`, which are private to it, the latter doubled, as
/// it bounds the path by up to 1.5 times as much (sums of lengths, where here is the length of a sum). Less: boxes
/// about moving shapes part some that touch.
inline constexpr double touch_of_size = 1e-14;
inline constexpr double touch_of_path = 2e-10;
/// The relative growth of a bound when it is rounded to single precision: 8 of its epsilon. Less: the bound is below
/// the motion, and the largest motion of a step is reported too small.
inline constexpr double bound_of_floats = 1e-6;

/// Bodies whose rotation is not orthonormal: the sine of the angle of a direction to the axis below which all points
/// of a circular edge are equally far out, and a single one of them is no answer. Less: the point is noise. More: it is
/// off by as much of the radius.
inline constexpr double along_axis = 1e-9;
/// The turn of a normal, radians, below which the iteration has converged. Less: eight rounds without convergence.
/// More: depths off by its square.
inline constexpr double normal_turned = 1e-12;
/// The difference of the upper and lower bound on a gap that counts as zero, relative to the size: 45 epsilon.
inline constexpr double bounds_meet = 1e-14;
/// The angle, radians, to the direction at which the last points of an inner hull lie: the root of epsilon, because
/// less makes no difference. Less: more rounds, with coincident points.
inline constexpr double nearest_beside = 2e-8;

/// The angle, radians, to the direction of the first points of the inner hull; each round divides it by ten: half a
/// degree, so that the bound between them (its square) is close already. Ten times more or less: one more round.
inline constexpr double first_beside = 1e-2;

/// The distance of a body at rest from where its rest began, as a share of the tolerance: a body that hangs in a
/// contact held constant drifts so far and no farther before its contacts are recomputed. Less: trembling bodies never
/// rest. More: kept contacts are off by as much.
inline constexpr double rest_share = 1e-3;
/// The share of the squared reach of a rest within which a body rests: what is missing covers the rounding of the
/// squares, and rotations that are orthonormal only to 2e-6. Nearer to 1: a body rests that has left its reach. Less:
/// rests end sooner.
inline constexpr double squared_reach = 0.99;
/// The share of the tolerance, radians, by which a body may have turned for an answer to be moved along: the rest is
/// left for its turn while it then rests, ten times rest_share. Nearer to 1: kept normals are off by more than the
/// tolerance. Less: more answers are computed.
inline constexpr double moved_turn = 0.99;

/// The motion in a step of a continuous body without an inner ball, such as a sheet, relative to its size, up to which
/// no time of impact is computed (other bodies: fast_motion of the inner radius). Less: slow sheets cost a time of
/// impact. More: they pass through thin bodies.
inline constexpr double fast_surface = 1e-2;

/// The deviation of a link's rotation from orthonormal, in single precision, above which its pose is tested in double
/// precision: the narrow phase's `skew_allowed`, which is private to it and decides, is larger by 6 epsilon of floats,
/// of which rounding takes 3. Less: valid poses are tested twice. More: invalid ones pass.
inline constexpr double skew_of_links = 1.2e-6;
/// The error of a gap between two rotated boxes, in single precision, relative to their extent and distance: twice the
/// sum of rounding (1e-6) and of rotations that are off by 2e-6 each. Less: a touch is missed. More: separated pairs
/// are tested in double precision.
inline constexpr double gap_of_floats = 2e-5;
/// The growth of the lowest nodes' surface by refits from which a hierarchy of queries is rebuilt. More: queries visit
/// that many more boxes. Less: rebuilds, each as costly as ten refits, for bodies that return.
inline constexpr double worn_hierarchy = 1.5;
/// The rounding of two distances that are compared to exclude the farther one, relative: 16 epsilon. Less: of two
/// equally far bodies the first by index may be excluded.
inline constexpr double distance_rounding = 4e-15;
/// The gap left after a motion from which the pair is skipped, relative to the link's reach: five times the error from
/// rotations that are off by 2e-6. Less: such rotations hide a touch. More: more pairs are tested.
inline constexpr double gap_left = 1e-5;

/// The least moment of inertia of a body that a response moves, relative to its largest: that of a needle some 12,000
/// times as long as wide. Less: the inverse in world axes is lost in rounding, and contacts throw needles 100,000 times
/// as long as wide away. More: thick needles turn too slowly about their axes.
inline constexpr double least_moment = 1e-8;
/// The masses, kg, and moments of inertia, kg m^2, beyond which bodies do not move: the product of three inverse
/// moments, and the square of one times the square of an arm of 1e30 m, are finite, and so are their inverses. Ten
/// times less or more changes nothing for realistic bodies.
inline constexpr double lightest_mass = 1e-80, heaviest_mass = 1e80;

/// The longest time step of a response and of a scene file, s. With longer ones bodies would leave the range of valid
/// poses.
inline constexpr double longest_time_step = 1000;
/// The permitted time steps, for messages.
inline constexpr const char* time_step_range = "> 0, at most 1000 s";

}  // namespace tandem::tolerance
