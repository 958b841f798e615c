// Common parts of all relations: tolerances, frequent queries, and descriptions of contradictions.
#pragma once
#include <algorithm>
#include <limits>
#include <sstream>
#include <string>

#include "relations.h"

namespace tandem::relations {

// Tolerances relative to unit_of(pair).
inline constexpr double rounding = 1e-12;  ///< of distances that are the same real number
/// The distance of witness points from the surfaces; on curved ones, points are less exact.
inline constexpr double surface = 1e-9;
inline constexpr double early = 1e-9;  ///< relative to the path: how much before a contact the time of impact may be
/// Relative to the path: rotating bodies touch from this gap on (`NarrowPhase::time_of_impact`).
inline constexpr double as_touch = 1e-10;

inline constexpr double infinity = std::numeric_limits<double>::infinity();

inline const NarrowPhase& plain() {
  static const NarrowPhase solver;
  return solver;
}

template <class... T>
std::string say(const T&... words) {
  std::ostringstream out;
  out.precision(17);
  (out << ... << words);
  return out.str();
}

inline PairAnswer distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  return plain().solve(a, pose_a, b, pose_b, Request::distance);
}

inline bool collide(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  return plain().solve(a, pose_a, b, pose_b, Request::collide).collide;
}

/// The rounding of coordinates at this distance from the origin, metres: the error of B's position after a motion.
inline double world_rounding(const PosedPair& p) {
  return 0x1p-51 * std::max(p.a.pose.translation.cwiseAbs().maxCoeff(), p.b.pose.translation.cwiseAbs().maxCoeff());
}

/// The difference of two answers for the same real numbers, the second for lengths times `factor`; empty if they agree.
/// `verdicts`: compares also results that rounding could change: verdicts, the number of contacts and their features.
std::string difference(const Answers& x, const Answers& y, double factor, double unit, bool verdicts, double margin);

inline bool is_mesh(const Shape& s) { return s.kind() == ShapeKind::mesh; }

}  // namespace tandem::relations
