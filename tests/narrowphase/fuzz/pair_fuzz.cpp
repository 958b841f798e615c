// Judges the narrow phase on pairs made from bytes.
#include "pair_fuzz.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "judge.h"
#include "pair_bytes.h"
#include "shapes/hull.h"
#include "shapes/shape_insides.h"
#include "shapes/support.h"

namespace {

using namespace tandem;
using reference::PosedPair;

constexpr double span_of_sizes = 1e5;

bool finite(const PairAnswer& r) {
  return std::isfinite(r.signed_distance) && r.normal.allFinite() && r.point_a.allFinite() && r.point_b.allFinite() &&
         std::isfinite(r.error_bound) && r.error_bound >= 0 && std::abs(r.normal.norm() - 1) < 1e-12;
}

/// True if sizes, aspect ratios and the distance are within 1e5 of each other.
bool is_moderate(const PosedPair& p) {
  const auto thin = [](const Shape& s) {
    if (!s.is_bounded()) return false;
    const Bounds b = s.bounds({});
    const double least = (b.hi - b.lo).minCoeff(), most = (b.hi - b.lo).maxCoeff();
    return least > 0 && most > span_of_sizes * least;
  };
  const double a = p.a.size() > 0 ? p.a.size() : p.b.size(), b = p.b.size() > 0 ? p.b.size() : p.a.size();
  const double between = (p.pose_b.translation - p.pose_a.translation).norm();
  return !thin(p.a) && !thin(p.b) && a < span_of_sizes * b && b < span_of_sizes * a &&
         between < span_of_sizes * (a + b);
}

/// True if the shape is at least a hundredth of its length thick in every direction.
bool is_plump(const Shape& s) {
  switch (s.kind()) {
    case ShapeKind::halfspace:
      return true;
    case ShapeKind::triangle:
      return false;
    case ShapeKind::convex: {
      const Hull& hull = hull_of(s);
      double width = hull.dimension == 3 ? s.size() : 0;
      for (const Hull::Face& face : hull.faces) {
        double below = 0;
        for (const Vec3& v : hull.vertices) below = std::max(below, face.offset - face.normal.dot(v));
        width = std::min(width, below);
      }
      return width > 1e-2 * s.size();
    }
    default: {
      const Bounds b = s.bounds({});
      return (b.hi - b.lo).minCoeff() > 1e-2 * (b.hi - b.lo).maxCoeff();
    }
  }
}

bool has_curved_core(const PosedPair& p) { return !is_polytope(p.a.kind()) || !is_polytope(p.b.kind()); }

/// Answers must be finite, right to `share` of the size, and the same with A and B exchanged; `share` 0: only finite.
std::string judge_coarsely(const NarrowPhase& solver, const PosedPair& p, double share) {
  std::vector<Contact> contacts;
  const PairAnswer r = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::contacts, &contacts);
  const PairAnswer d = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
  const PairAnswer s = solver.solve(p.b, p.pose_b, p.a, p.pose_a, Request::distance);
  if (!finite(d) || !finite(s)) return "distance: not finite\n";
  if (r.collide && !finite(r)) return "contacts: not finite\n";
  for (const Contact& c : contacts)
    if (!c.point.allFinite() || !c.normal.allFinite() || !std::isfinite(c.depth)) return "contacts: not finite\n";
  if (share == 0) return {};
  const reference::Truth t = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
  const double between = test::reach(p);
  const double bound = share * reference::size(p) + 1e-15 * between + t.error + d.error_bound;
  if (!(std::abs(d.signed_distance - t.signed_distance) <= bound))
    return "distance: " + std::to_string(d.signed_distance) + " for " + std::to_string(t.signed_distance) + '\n';
  if (d.collide != r.collide && std::abs(d.signed_distance) > bound) return "contacts: another verdict\n";
  if (!(std::abs(d.signed_distance - s.signed_distance) <= 2 * bound)) return "swapped: another signed distance\n";
  return {};
}

}  // namespace

namespace tandem::test {

std::string judge_bytes(std::span<const std::uint8_t> bytes, Asked asked) {
  static const NarrowPhase solver;
  const auto pair = pair_from_bytes(bytes);
  if (!pair) return {};
  if (asked == Asked::of_flat_strictly) asked = has_curved_core(*pair) ? Asked::of_all : Asked::strictly;
  std::string wrong;
  try {
    if (asked == Asked::strictly && is_moderate(*pair))
      wrong = judge(solver, *pair, reference::signed_distance(pair->a, pair->pose_a, pair->b, pair->pose_b));
    else if (asked == Asked::of_plump && !(is_moderate(*pair) && is_plump(pair->a) && is_plump(pair->b)))
      wrong = judge_coarsely(solver, *pair, 0);
    else
      wrong = judge_coarsely(solver, *pair, asked == Asked::strictly ? 1e-7 : 1e-3);
  } catch (const std::exception& error) {
    wrong = std::string("exception: ") + error.what() + '\n';
  }
  return wrong.empty() ? wrong : wrong + record(*pair);
}

}  // namespace tandem::test
