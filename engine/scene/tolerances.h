#pragma once

/// The tolerances of the engine, each defined once. Those shared with the narrow phase are in narrowphase/tolerances.h.
namespace tandem::tolerance {

/// How far the norm of a quaternion in a file may be from 1: six digits leave 1e-6. Less: files written so are refused.
inline constexpr double quaternion_norm = 1e-6;

/// More than rotations, which are orthonormal to 2e-6 only, stretch a body's motion by, relative: the narrow phase's
/// `askew`, which is private to it. Less: a contact is kept that a fast body has left.
inline constexpr double motion_stretch = 4e-6;
/// Of a place after a motion, relative to the numbers in it: 18 epsilon. Less: the same, for bodies that hardly move.
inline constexpr double motion_rounding = 4e-15;
/// What a bound grows by when it is rounded to single precision, relative: 8 of its epsilon. Less: the bound is less
/// than the motion, and the largest motion of a step is told too small.
inline constexpr double bound_of_floats = 1e-6;

/// Bodies whose rotation has a rest: the sine to the axis below which all of a rim is as far out, and one point of it
/// no answer. Less: the point is noise. More: it is off by as much of the radius.
inline constexpr double along_axis = 1e-9;
/// A normal that no longer turns, radians. Less: eight rounds without end. More: depths off by its square.
inline constexpr double normal_turned = 1e-12;
/// Upper and lower bound on what they are apart by are one, relative to the size: 45 epsilon.
inline constexpr double bounds_meet = 1e-14;
/// How near, in radians, the last points of an inner hull lie beside the direction: root of epsilon, for what lies
/// nearer does not show. Less: more rounds, of points in one place.
inline constexpr double nearest_beside = 2e-8;

/// How far beside it the first ones lie, radians, a tenth of it each round after: half a degree, so that the bound
/// between them (the square of it) is near already. Ten times more or less: a round more.
inline constexpr double first_beside = 1e-2;

/// How far a body at rest may be from where its rest began, of what the tolerance allows: a body that hangs in a
/// contact held constant drifts so far and no farther before it is looked at again. Less: bodies that tremble never
/// rest. More: contacts held are off by as much.
inline constexpr double rest_share = 1e-3;

/// How far a continuous body without a ball inside, such as a sheet, may move in a step without being looked at in
/// time: of its size, in place of fast_motion of its radius. Less: slow sheets cost a time of impact. More: they pass
/// through what is as thin.
inline constexpr double fast_surface = 1e-2;

/// How far a link's rotation may be from orthonormal, in single precision, before its pose is looked at more closely:
/// the narrow phase's `skew_allowed`, which is private to it and decides, is more by 6 epsilon of floats, of which
/// rounding takes 3. Less: valid poses are looked at twice. More: bad ones pass.
inline constexpr double skew_of_links = 1.2e-6;
/// Of a gap between two boxes that are turned, in single precision, relative to what they reach and are apart by: twice
/// what rounding (1e-6) and rotations that are off by 2e-6 each make of it. Less: a touch is passed over. More: pairs
/// are looked at that are apart.
inline constexpr double gap_of_floats = 2e-5;
/// A hierarchy of queries is built anew when refits have made the surface of its lowest nodes larger by this factor.
/// More: queries meet that many more boxes. Less: builds, which cost ten refits, for bodies that come back.
inline constexpr double worn_hierarchy = 1.5;
/// Of two distances that are compared to leave out the farther one, relative: 16 epsilon. Less: of two bodies equally
/// far the first by index may be left out.
inline constexpr double distance_rounding = 4e-15;
/// What is left of a gap after a motion for the pair to be passed over, relative to the link's reach: five times what
/// rotations that are off by 2e-6 make of it. Less: such rotations hide a touch. More: more pairs are looked at.
inline constexpr double gap_left = 1e-5;

/// kg: bodies beyond stay where they are. Products of two such, and their inverses, are numbers. Ten times less or
/// more: nothing changes for any body of this world.
inline constexpr double lightest_mass = 1e-100, heaviest_mass = 1e100;

/// s: the longest time step of a response and of a scene file. Of more, bodies go where no pose may be.
inline constexpr double longest_time_step = 1000;

}  // namespace tandem::tolerance
