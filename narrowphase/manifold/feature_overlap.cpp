// Overlaps of two features: faces clipped (Sutherland and Hodgman 1974), parallel edges.
#include "manifold/feature_overlap.h"

#include <algorithm>

#include "tolerances.h"

namespace tandem {
namespace {

constexpr double sharp = 0.96;  // squared cosine: an angle of 11 degrees

/// A polygon being clipped. `edge` labels the side after each corner: the incident face's sides by number, the
/// reference face's from max_corners on. Two labels name a corner, the same in the next step.
struct Clipped {
  Vec3 corner[max_clipped];
  std::uint32_t edge[max_clipped];
  int count = 0;
  bool open = false;  ///< a segment, or two connected ones

  void add(const Vec3& p, std::uint32_t label) {
    if (count < max_clipped) corner[count] = p, edge[count++] = label;
  }
};

/// Keeps the part on the inner side of the plane normal . x <= offset; a corner beyond it by at most `slack`, times the
/// normal's length, counts as inside, so that rounding decides nothing where sides coincide. False: all is kept, and
/// `out` is not set.
bool clip(const Clipped& c, const Vec3& normal, double offset, double slack, std::uint32_t label, Clipped& out) {
  double beyond[max_clipped];
  bool any = false;
  const double on_it = slack * normal.norm();
  for (int i = 0; i < c.count; ++i) {
    beyond[i] = normal.dot(c.corner[i]) - offset;
    any |= !(beyond[i] <= on_it);
  }
  if (!any) return false;
  out.open = c.open;
  out.count = 0;
  for (int i = 0; i < c.count; ++i) {
    const int j = i + 1 < c.count ? i + 1 : 0;
    const double di = beyond[i], dj = beyond[j];
    if (di <= on_it) out.add(c.corner[i], c.edge[i]);
    if (c.open && j == 0) break;  // a segment has no closing side
    // A corner in the plane represents the crossing.
    if ((di <= 0 && dj > on_it) || (di > on_it && dj <= 0)) {
      const double t = di / (di - dj);
      out.add(c.corner[i] + t * (c.corner[j] - c.corner[i]), di <= 0 ? label : c.edge[i]);
    }
  }
  return true;
}

/// Is the corner between two sides sharp, of which these are the outward directions?
bool is_sharp(const Vec3& side, const Vec3& next) {
  const double opposed = side.dot(next);
  return opposed < 0 && opposed * opposed > sharp * side.squaredNorm() * next.squaredNorm();
}

std::uint32_t feature_number(const FlatFeature& reference, bool of_b, std::uint32_t in, std::uint32_t out) {
  return (of_b ? 1u << 31 : 0u) | ((reference.id & 0xfffffu) << 11) | (in << 5 & 0x7e0u) | (out & 0x1fu);
}

/// Do all corners of a triangle lie beyond one side of a face by more than `most`, in a view along its normal?
bool lies_beside(const FlatFeature& triangle, const FlatFeature& face, double most) {
  for (int i = 0; i < face.count; ++i) {
    const Vec3 &from = face.corner[i], &to = face.corner[i + 1 < face.count ? i + 1 : 0];
    const Vec3 out = triangle.normal.cross(to - from);
    const double offset = out.dot(from);
    const double beyond =
        std::min({out.dot(triangle.corner[0]), out.dot(triangle.corner[1]), out.dot(triangle.corner[2])}) - offset;
    if (beyond > 0 && beyond * beyond > most * most * out.squaredNorm()) return true;
  }
  return false;
}

}  // namespace

int clip_faces(const FlatFeature& reference, const FlatFeature& incident, const Vec3& outward, bool of_b, double margin,
               double deepest, double slack, PatchPoint* points) {
  Clipped buffer[2];
  int last = 0;
  buffer[0].open = !incident.is_face();
  for (int i = 0; i < incident.count; ++i) buffer[0].add(incident.corner[i], static_cast<std::uint32_t>(i));
  const auto corner = [&](int i) -> const Vec3& {
    return reference.corner[i < reference.count ? i : i - reference.count];
  };
  const auto cut = [&](const Vec3& side, const Vec3& at, std::uint32_t label) {
    if (clip(buffer[last], side, side.dot(at), slack, max_corners + label, buffer[1 - last])) last = 1 - last;
  };
  Vec3 side = (corner(1) - corner(0)).cross(outward);
  for (int i = 0; i < reference.count && buffer[last].count > 0; ++i) {
    const std::uint32_t label = static_cast<std::uint32_t>(i);
    cut(side, corner(i), label);
    const Vec3 next = (corner(i + 2) - corner(i + 1)).cross(outward);
    // A point far beyond a sharp corner may be near both of its sides.
    if (is_sharp(side, next))
      cut(outward.cross(side / std::sqrt(side.squaredNorm()) - next / std::sqrt(next.squaredNorm())), corner(i + 1),
          label);
    side = next;
  }
  const Clipped& c = buffer[last];
  const double slant = reference.normal.dot(outward);
  int count = 0;
  for (int i = 0; i < c.count; ++i) {
    Vec3 at = c.corner[i];
    const bool lowest = incident.lowest >= 0 && at == incident.corner[incident.lowest];
    if (incident.radius > 0) {
      // Cut off between the side line and the farthest point: the point lies on the ball, not on the line.
      const Vec3 out = at - incident.ball;
      const double along = outward.dot(out), across2 = (out - along * outward).squaredNorm(),
                   radius2 = incident.radius * incident.radius;
      if (incident.end.dot(out) > tolerance::alike * incident.radius && across2 < radius2)
        at -= (along + std::sqrt(radius2 - across2)) * outward;
    }
    // At most the pair's depth, since moving by that separates the shapes.
    const double depth = std::min(deepest, reference.normal.dot(reference.corner[0] - at) / slant);
    if (depth < -margin - slack) continue;
    const std::uint32_t in = c.edge[(i + c.count - 1) % c.count];
    points[count++] = {at + 0.5 * depth * outward, std::max(depth, -margin),
                       feature_number(reference, of_b, in, c.edge[i]), lowest};
  }
  return count;
}

int clip_over_triangle(const FlatFeature& triangle, const FlatFeature& incident, double margin, double deepest,
                       double slack, PatchPoint* points) {
  constexpr int ample = 16;  // clipping keeps what is beyond a corner of 11 degrees by this
  if (incident.is_face() && lies_beside(triangle, incident, ample * slack)) return 0;
  return clip_faces(triangle, incident, triangle.normal, false, margin, deepest, slack, points);
}

int overlap_edges(const FlatFeature& a, const FlatFeature& b, const LocalAnswer& answer, double margin, double size,
                  PatchPoint* points) {
  const Vec3 along = a.corner[1] - a.corner[0], other = b.corner[1] - b.corner[0];
  const double length2 = along.squaredNorm();
  if (!(length2 > 0) || along.cross(other).squaredNorm() > tolerance::flush2 * length2 * other.squaredNorm()) return 0;
  const double t0 = along.dot(b.corner[0] - a.corner[0]) / length2, t1 = along.dot(b.corner[1] - a.corner[0]) / length2;
  const double lo = std::max(std::min(t0, t1), 0.0), hi = std::min(std::max(t0, t1), 1.0);
  if (!(hi > lo)) return 0;
  int count = 0;
  for (const double t : {lo, hi}) {
    const Vec3 on_a = a.corner[0] + t * along;
    const Vec3 on_b = b.corner[0] + std::clamp((t - t0) / (t1 - t0), 0.0, 1.0) * other;
    const double here = answer.normal.dot(on_a - on_b);
    if (here < -margin - tolerance::alike * size) continue;
    const double depth = std::max(std::min(here, -answer.signed_distance), -margin);
    const bool at_first = t == lo;
    const bool of_a = at_first ? std::min(t0, t1) <= 0 : std::max(t0, t1) >= 1;
    points[count++] = {0.5 * (on_a + on_b), depth, feature_number(a, false, at_first ? 0 : 1, of_a ? 2 : 1)};
  }
  return count;
}

}  // namespace tandem
