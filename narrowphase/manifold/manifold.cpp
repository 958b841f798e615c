#include "manifold/manifold.h"

#include <bit>
#include <tuple>

#include "manifold/faces_along.h"
#include "shapes/hull.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int max_corners = 16;  // of a face that is clipped; circles have this many
constexpr int max_clipped = 3 * max_corners;
constexpr int max_patch = max_clipped + 1;
constexpr std::uint32_t witness_point = 0xffffffffu;  // deeper than all that clipping found
constexpr double rim_lacks = 0.25;                    // what it may lack to the greatest depth, in `alike`
constexpr double sharp = 0.96;                        // squared cosine: a tip of 11 degrees

/// A face (3 or more corners, counterclockwise from outside), an edge or a point of a shape, in some frame. Or what a
/// capsule that leans shows: the edge along its side, and beyond its end the point of the ball that reaches farthest.
struct FlatFeature {
  Vec3 corner[max_corners];
  int count = 0;
  int rim = -1;                ///< the corner that is a leaning disc's deepest point
  Vec3 normal = Vec3::Zero();  ///< unit, of a face
  std::uint32_t id = 0;
  Vec3 ball = Vec3::Zero();  ///< centre of a capsule's end
  double radius = 0;         ///< of it; 0 for all else
  Vec3 end = Vec3::Zero();   ///< unit, along the axis towards that end

  bool is_face() const { return count >= 3 && radius == 0; }

  void add(const Vec3& p) { corner[count++] = p; }
};

/// The corners of a circle's polygon, counterclockwise from the x axis.
struct CirclePolygon {
  double x[max_corners + 1], y[max_corners + 1];

  constexpr CirclePolygon() : x{}, y{} {
    constexpr double cos_step = 0.92387953251128675613, sin_step = 0.38268343236508977173;  // pi / 8
    x[0] = x[max_corners] = 1;
    for (int i = 0; i + 1 < max_corners; ++i) {
      x[i + 1] = x[i] * cos_step - y[i] * sin_step;
      y[i + 1] = y[i] * cos_step + x[i] * sin_step;
    }
  }
};

constexpr CirclePolygon circle;

/// The last corner before a direction.
int corner_before(double x, double y) {
  int i = 0;
  if (y < 0) x = -x, y = -y, i = max_corners / 2;
  if (x <= 0) std::tie(x, y) = std::pair(y, -x), i += max_corners / 4;
  for (int k = 1; k < max_corners / 4; ++k) i += circle.x[k] * y >= circle.y[k] * x ? 1 : 0;
  return i;
}

/// A power of two no larger than the root of v > 0.
double power_below_root(double v) {
  const auto exponent = static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(v) >> 52) - 1023;
  return std::bit_cast<double>(static_cast<std::uint64_t>((exponent >> 1) + 1023) << 52);
}

/// Where (unit: x, y) a disc that leans by rho, the sine of the angle, is deepest. The less it leans, the farther
/// that moves when the pose changes a little: on a grid so wide that the depth there is within 1.25e-9 of the radius of
/// the greatest it mostly stays.
void find_deepest_of_rim(double rho, double& x, double& y) {
  constexpr double steady = 1e-3;  // 1e-9 moves it by less than 1e-6
  if (rho >= steady) return;
  // By tangents from the nearest of eight directions, between which no likely angle lies in the middle.
  const double ax = std::abs(x), ay = std::abs(y);
  const bool diagonal = std::min(ax, ay) > 0.41421356 * std::max(ax, ay);
  const double cx = diagonal || ax > ay ? std::copysign(1.0, x) : 0.0;
  const double cy = diagonal || ay >= ax ? std::copysign(1.0, y) : 0.0;
  const double step = power_below_root(tolerance::rim_lacks2 / rho);  // rho step^2 / 8 is what the depth lacks
  constexpr double to_whole = 0x1.8p52;
  const double t = ((cx * y - cy * x) / (cx * x + cy * y) / step + to_whole - to_whole) * step;
  const double length = std::sqrt((cx * cx + cy * cy) * (1 + t * t));
  x = (cx - t * cy) / length;
  y = (cy + t * cx) / length;
}

/// The polygon has its place on the body, so that it stays where the deepest point does not; that one takes the place
/// of the nearest corner. So the deepest point, the one across and those to either side are nearly a square wherever it
/// lies, and carry a body alike however it leans: with three that stay and the deepest anywhere between them stacks
/// swayed for ever. A disc that counts as flat has none.
void add_circle(FlatFeature& f, double radius, double z, const Vec3& towards, bool counterclockwise) {
  const double width = counterclockwise ? radius : -radius;
  for (int i = 0; i < max_corners; ++i) f.add({radius * circle.x[i], width * circle.y[i], z});
  const double rho = std::sqrt(towards[0] * towards[0] + towards[1] * towards[1]);
  if (!(rho > tolerance::alike)) return;
  double x = towards[0] / rho, y = std::copysign(1.0, width) * towards[1] / rho;
  find_deepest_of_rim(rho, x, y);
  const int before = corner_before(x, y);
  const auto cosine = [&](int i) { return circle.x[i] * x + circle.y[i] * y; };
  f.rim = (cosine(before + 1) > cosine(before) ? before + 1 : before) % max_corners;
  f.corner[f.rim] = {radius * x, width * y, z};
}

/// The face that looks most along d (unit); of equals the first.
std::size_t facing_most(const Hull& hull, const Vec3& d) {
  if (!hull.normals.empty()) return face_kernel()(hull, d.data());
  std::size_t best = 0;
  double most = -infinity;
  const auto look = [&](std::size_t i) {
    if (const double along = hull.faces[i].normal.dot(d); along > most) most = along, best = i;
  };
  if (hull.face_table.faces == 0) {
    for (std::size_t i = 0; i < hull.faces.size(); ++i) look(i);
    return best;
  }
  const FaceBits bits = faces_along(hull.face_table, d);
  for (std::size_t k = 0; k < bits.size(); ++k)
    for (std::uint64_t left = bits[k]; left != 0; left &= left - 1)
      look(64 * k + static_cast<std::size_t>(std::countr_zero(left)));
  return best;
}

FlatFeature face_of_box(const ConvexView& v, const Vec3& d) {
  FlatFeature f;
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(d[i]) > std::abs(d[k])) k = i;
  const int u = (k + 1) % 3, w = (k + 2) % 3;
  const double side = std::copysign(1.0, d[k]);
  f.normal[k] = side;
  constexpr double su[4] = {1, -1, -1, 1}, sw[4] = {1, 1, -1, -1};
  for (int i = 0; i < 4; ++i) {
    Vec3 p;
    const int at = side > 0 ? i : 3 - i;
    p[k] = side * v.param[static_cast<std::size_t>(k)];
    p[u] = su[at] * v.param[static_cast<std::size_t>(u)];
    p[w] = sw[at] * v.param[static_cast<std::size_t>(w)];
    f.add(p);
  }
  f.id = static_cast<std::uint32_t>(2 * k + (side > 0 ? 0 : 1));
  return f;
}

/// Of a capsule the line of its side; unless it lies flat, what reaches farthest is beyond an end of that, and its
/// direction another.
FlatFeature face_of_capsule(const ConvexView& v, const Vec3& d) {
  FlatFeature f;
  const double h = 0.5 * v.param[1], r = v.param[0], rho = std::sqrt(d[0] * d[0] + d[1] * d[1]);
  const bool leans = std::abs(d[2]) > tolerance::flush;
  if (leans && d[2] > 0) f.add(Vec3(0, 0, h) + r * d);
  if (rho > tolerance::alike) {
    const Vec3 side = leans ? Vec3(r * (d[0] / rho), r * (d[1] / rho), 0) : Vec3(r * d);
    f.add(Vec3(0, 0, h) + side);
    f.add(Vec3(0, 0, -h) + side);
  }
  if (leans && d[2] < 0) f.add(Vec3(0, 0, -h) + r * d);
  if (leans) {
    f.end[2] = std::copysign(1.0, d[2]);
    f.ball = h * f.end;
    f.radius = r;
  }
  return f;
}

/// A disc as a polygon, else a line of the side.
FlatFeature face_of_cylinder(const ConvexView& v, const Vec3& d) {
  FlatFeature f;
  const double h = 0.5 * v.param[1], rho = std::sqrt(d[0] * d[0] + d[1] * d[1]);
  if (std::abs(d[2]) > rho) {
    f.normal = {0, 0, std::copysign(1.0, d[2])};
    add_circle(f, v.param[0], std::copysign(h, d[2]), d, d[2] > 0);
    f.id = d[2] > 0 ? 1 : 2;
  } else {
    const double x = v.param[0] * d[0] / rho, y = v.param[0] * d[1] / rho;
    f.add({x, y, h});
    f.add({x, y, -h});
  }
  return f;
}

/// Its disc, else a line of the side.
FlatFeature face_of_cone(const ConvexView& v, const Vec3& d) {
  FlatFeature f;
  const double r = v.param[0], length = v.param[1], rho = std::sqrt(d[0] * d[0] + d[1] * d[1]);
  const double side = (length * rho + r * d[2]) / std::sqrt(r * r + length * length);
  if (-d[2] >= side) {
    f.normal = {0, 0, -1};
    add_circle(f, r, -0.5 * length, d, false);
    f.id = 1;
  } else {
    f.add({0, 0, 0.5 * length});
    if (rho > shortest_squared) f.add({r * d[0] / rho, r * d[1] / rho, -0.5 * length});
  }
  return f;
}

/// Of a hull or triangle; of one without area the segment or point.
FlatFeature face_of_hull(const ConvexView& v, const Vec3& d) {
  FlatFeature f;
  if (v.hull != nullptr && !v.hull->faces.empty()) {
    const std::size_t best = facing_most(*v.hull, d);
    const Hull::Face& face = v.hull->faces[best];
    f.normal = face.normal;
    f.id = static_cast<std::uint32_t>(best);
    // A face with more corners than fit is thinned evenly.
    const std::uint32_t kept = std::min<std::uint32_t>(face.count, max_corners);
    for (std::uint32_t i = 0; i < kept; ++i) f.add(v.vertices[v.hull->loop[face.first + i * face.count / kept]]);
    return f;
  }
  if (v.vertices.size() == 3) {
    const Vec3 n = (v.vertices[1] - v.vertices[0]).cross(v.vertices[2] - v.vertices[0]);
    const double length = n.norm();
    if (length > 0) {
      const bool front = n.dot(d) >= 0;
      f.normal = unit(front ? n : Vec3(-n), length);
      for (std::size_t i = 0; i < 3; ++i) f.add(v.vertices[front ? i : 2 - i]);
      f.id = front ? 0 : 1;
      return f;
    }
  }
  for (std::size_t i = 0; i < v.vertices.size() && i < 2; ++i) f.add(v.vertices[i]);
  return f;
}

/// The face that looks most along d, or the edge or point that stands for it on round shapes.
FlatFeature best_face(const ConvexView& v, const Vec3& d) {
  if (v.kind == ShapeKind::box) return face_of_box(v, d);
  if (v.kind == ShapeKind::capsule) return face_of_capsule(v, d);
  if (v.kind == ShapeKind::cylinder) return face_of_cylinder(v, d);
  if (v.kind == ShapeKind::cone) return face_of_cone(v, d);
  if (v.kind == ShapeKind::convex || v.kind == ShapeKind::triangle) return face_of_hull(v, d);
  FlatFeature f;
  f.add(core_support(v, d) + core_radius(v) * d);
  return f;
}

/// The edge that lies in the contact plane with outward normal d; none (count 0) if it is not an edge.
FlatFeature flush_edge(const ConvexView& v, const Vec3& d) {
  FlatFeature f;
  switch (v.kind) {
    case ShapeKind::box: {
      int along = -1, flat = 0;
      for (int k = 0; k < 3; ++k)
        if (std::abs(d[k]) <= tolerance::flush) along = k, ++flat;
      if (flat != 1) return f;
      Vec3 p = core_support(v, d);
      f.id = static_cast<std::uint32_t>(along);
      p[along] = v.param[static_cast<std::size_t>(along)];
      f.add(p);
      p[along] = -p[along];
      f.add(p);
      return f;
    }
    case ShapeKind::capsule:
    case ShapeKind::cylinder:
      if (std::abs(d[2]) <= tolerance::flush) return best_face(v, d);
      return f;
    case ShapeKind::cone: {
      const double r = v.param[0], length = v.param[1], rho = std::sqrt(d[0] * d[0] + d[1] * d[1]);
      if (std::abs(length * d[2] - r * rho) <= tolerance::flush * std::sqrt(r * r + length * length))
        return best_face(v, d);
      return f;
    }
    case ShapeKind::convex:
    case ShapeKind::triangle: {
      const double most = core_support(v, d).dot(d);
      for (const Vec3& p : v.vertices)
        if (p.dot(d) >= most - tolerance::flush * v.size) {
          if (f.count == 2) {
            f.count = 0;
            return f;
          }
          f.add(p);
        }
      if (f.count != 2) f.count = 0;
      return f;
    }
    default:
      return f;
  }
}

void move(FlatFeature& f, const RelativePose& pose) {
  for (int i = 0; i < f.count; ++i) f.corner[i] = pose.rotation * f.corner[i] + pose.translation;
  f.normal = pose.rotation * f.normal;
  if (f.radius > 0) {
    f.ball = pose.rotation * f.ball + pose.translation;
    f.end = pose.rotation * f.end;
  }
}

/// A polygon being clipped; `edge` labels the side that leaves each corner: the incident face's sides by number,
/// the reference face's from max_corners on. Two labels name a corner, the same way in the next step.
struct Clipped {
  Vec3 corner[max_clipped];
  std::uint32_t edge[max_clipped];
  int count = 0;
  bool open = false;  ///< a segment, or two that meet

  void add(const Vec3& p, std::uint32_t label) {
    if (count < max_clipped) corner[count] = p, edge[count++] = label;
  }
};

/// Keeps what lies on the inner side of the plane normal . x <= offset; a corner beyond it by `slack` at most, times
/// the normal's length, counts as in it: where sides lie on each other rounding decides nothing. False: all of it is
/// kept, and `out` is not set.
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
    if (c.open && j == 0) break;  // a segment has no way back
    // A corner in the plane is itself where its side crosses it.
    if ((di <= 0 && dj > on_it) || (di > on_it && dj <= 0)) {
      const double t = di / (di - dj);
      out.add(c.corner[i] + t * (c.corner[j] - c.corner[i]), di <= 0 ? label : c.edge[i]);
    }
  }
  return true;
}

std::uint32_t feature_number(const FlatFeature& reference, bool of_b, std::uint32_t in, std::uint32_t out) {
  return (of_b ? 1u << 31 : 0u) | ((reference.id & 0xfffffu) << 11) | (in << 5 & 0x7e0u) | (out & 0x1fu);
}

/// Points of `incident` over `reference`, seen along `outward` (the contact normal, from the reference's shape), by
/// depth along it: there the way leaves one shape and enters the other. Those beyond the margin by `slack` at most
/// count as at it: what touches to rounding has all of its patch.
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
    // What lies far beyond a tip may be next to both of its sides.
    const double opposed = side.dot(next), length2 = side.squaredNorm(), next2 = next.squaredNorm();
    if (opposed < 0 && opposed * opposed > sharp * length2 * next2)
      cut(outward.cross(side / std::sqrt(length2) - next / std::sqrt(next2)), corner(i + 1), label);
    side = next;
  }
  const Clipped& c = buffer[last];
  const double slant = reference.normal.dot(outward);
  int count = 0;
  for (int i = 0; i < c.count; ++i) {
    Vec3 at = c.corner[i];
    const bool rim = incident.rim >= 0 && at == incident.corner[incident.rim];
    if (incident.radius > 0) {
      // Cut off between the side and the farthest point, it lies on the ball and not on the line.
      const Vec3 out = at - incident.ball;
      const double along = outward.dot(out), across2 = (out - along * outward).squaredNorm(),
                   radius2 = incident.radius * incident.radius;
      if (incident.end.dot(out) > tolerance::alike * incident.radius && across2 < radius2)
        at -= (along + std::sqrt(radius2 - across2)) * outward;
    }
    // Moving by the pair's depth separates them everywhere, so nowhere is it more.
    const double depth = std::min(deepest, reference.normal.dot(reference.corner[0] - at) / slant);
    if (depth < -margin - slack) continue;
    const std::uint32_t in = c.edge[(i + c.count - 1) % c.count];
    points[count++] = {at + 0.5 * depth * outward, std::max(depth, -margin),
                       feature_number(reference, of_b, in, c.edge[i]), rim};
  }
  return count;
}

/// The stretch where two parallel edges lie side by side. Each end has its own depth: an angle within `flush` opens
/// by more than what nearly touches.
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

}  // namespace

void stand_for_deepest(PatchPoint* p, int count, double slack) {
  int first = 0;
  double deepest = p[0].depth;
  for (int i = 1; i < count; ++i) {
    if (p[i].depth > p[first].depth + slack) first = i;
    deepest = std::max(deepest, p[i].depth);
  }
  p[first].depth = deepest;
}

int span_patch(PatchPoint* p, int count, const Vec3& normal, double size) {
  const auto before = [](const PatchPoint& x, const PatchPoint& y) {
    return x.feature != y.feature ? x.feature < y.feature : x.depth > y.depth;
  };
  for (int i = 1; i < count; ++i)
    for (int k = i; k > 0 && before(p[k], p[k - 1]); --k) std::swap(p[k], p[k - 1]);
  if (count <= 2) return count;
  // The best of those not taken; a later one must be better by more than the slack.
  const double slack = tolerance::alike * size;
  bool taken[max_patch] = {};
  double most;
  const auto choose = [&](auto&& score) {
    int best = -1;
    most = 0;
    for (int i = 0; i < count; ++i) {
      if (taken[i]) continue;
      const double s = score(p[i]);
      if (best < 0 || s > most + slack) best = i, most = s;
    }
    taken[best] = true;
    return best;
  };
  double deepest = p[0].depth;
  for (int i = 1; i < count; ++i) deepest = std::max(deepest, p[i].depth);
  int start = -1;
  for (int i = 0; i < count; ++i)
    if (p[i].rim && p[i].depth >= deepest - rim_lacks * slack) start = i;
  if (start < 0)
    start = choose([&](const PatchPoint& x) { return x.feature == witness_point ? size : x.depth; });
  else
    taken[start] = true;
  const PatchPoint& first = p[start];
  p[start].depth = deepest;  // one that counts as equal stands for the deepest
  const auto from_first = [&first](const PatchPoint& x) { return (x.at - first.at).norm(); };
  const int second = choose(from_first);
  const double length = most;
  const Vec3 along = p[second].at - first.at, side = normal.cross(along / std::max(length, tolerance::never_zero));
  const int third = choose([&](const PatchPoint& x) { return std::abs(side.dot(x.at - first.at)); });
  if (most <= thin * length) {
    // A strip this thin is an edge: its deepest end, and the deepest at the other.
    taken[second] = taken[third] = false;
    choose([&](const PatchPoint& x) { return from_first(x) >= 0.9 * length ? size + x.depth : 0; });
  } else if (count > 4) {
    // The fourth: outside the triangle of the three by most.
    const double turn = side.dot(p[third].at - first.at) >= 0 ? 1.0 : -1.0;
    const Vec3 corner[4] = {first.at, p[second].at, p[third].at, first.at};
    Vec3 outward[3];
    for (int k = 0; k < 3; ++k) outward[k] = -turn * normal.cross(corner[k + 1] - corner[k]).normalized();
    const int fourth = choose([&](const PatchPoint& x) {
      double out = 0;
      for (int k = 0; k < 3; ++k) out = std::max(out, outward[k].dot(x.at - corner[k]));
      return out;
    });
    if (!(most > slack)) taken[fourth] = false;
  } else {
    return count;
  }
  int kept = 0;
  for (int i = 0; i < count; ++i)
    if (taken[i]) p[kept++] = p[i];
  return kept;
}

void append_points(const PatchPoint* points, int count, const Pose& pose, const Vec3& normal,
                   std::vector<Contact>& contacts) {
  for (int i = 0; i < count; ++i) contacts.push_back({pose * points[i].at, normal, points[i].depth, points[i].feature});
}

void append_manifold(const ConvexView& a, const ConvexView& b, const RelativePose& relative, const LocalAnswer& answer,
                     double margin, const Pose& pose_a, std::vector<Contact>& contacts, bool whole) {
  if (answer.signed_distance > margin) return;
  const Vec3& n = answer.normal;
  PatchPoint points[max_patch];
  int count = 0;
  const double slack = tolerance::alike * (a.size + b.size);
  const bool point_like = a.kind == ShapeKind::sphere || b.kind == ShapeKind::sphere ||
                          a.kind == ShapeKind::ellipsoid || b.kind == ShapeKind::ellipsoid;
  if (!point_like) {
    const Vec3 towards_a = -(relative.rotation.transpose() * n);
    FlatFeature fa = best_face(a, n), fb = best_face(b, towards_a);
    move(fb, relative);
    const double flat_a = fa.is_face() ? fa.normal.dot(n) : 0, flat_b = fb.is_face() ? -fb.normal.dot(n) : 0;
    // Of two that are as flat A's carries the patch, but a leaning disc is clipped by a face that does not lean: its
    // deepest point must be among what is left.
    const bool as_flat = std::abs(flat_a - flat_b) <= tolerance::alike_cosines;
    const bool only_a_leans = as_flat && fa.rim >= 0 && fb.rim < 0;
    if (flat_a >= carries_patch && (as_flat || flat_a > flat_b) && !(only_a_leans && flat_b >= carries_patch)) {
      count = clip_faces(fa, fb, n, false, margin, -answer.signed_distance, slack, points);
    } else if (flat_b >= carries_patch) {
      count = clip_faces(fb, fa, -n, true, margin, -answer.signed_distance, slack, points);
    } else {
      fa = flush_edge(a, n);
      if (fa.count == 2) fb = flush_edge(b, towards_a);
      if (fa.count == 2 && fb.count == 2) {
        move(fb, relative);
        count = overlap_edges(fa, fb, answer, margin, a.size + b.size, points);
      }
    }
    // The clipped circles are polygons, and a slanting face may not hold the deepest point: never lose that one.
    double deepest = -infinity;
    bool rim = false;
    for (int i = 0; i < count; ++i) {
      deepest = std::max(deepest, points[i].depth);
      rim |= points[i].rim;
    }
    if (count > 0 && deepest + (rim ? rim_lacks : 0.02) * slack >= -answer.signed_distance) {
      for (int i = 0; i < count; ++i)
        if (points[i].depth == deepest) points[i].depth = -answer.signed_distance;
      if (!whole) count = span_patch(points, count, n, a.size + b.size);
      append_points(points, count, pose_a, pose_a.rotation * n, contacts);
      return;
    }
  }
  points[count++] = {0.5 * (answer.point_a + answer.point_b), -answer.signed_distance, witness_point};
  if (!whole) count = span_patch(points, count, n, a.size + b.size);
  append_points(points, count, pose_a, pose_a.rotation * n, contacts);
}

bool append_parallel_capsules(const SegmentDistance& axes, double radius_a, double length_a, const Pose& pose_a,
                              double radius_b, double length_b, const Pose& pose_b, double margin,
                              std::vector<Contact>& contacts) {
  const Vec3 along = pose_a.rotation.col(2), other = pose_b.rotation.col(2);
  if (along.cross(other).squaredNorm() > tolerance::flush2 || std::abs(axes.normal.dot(along)) > tolerance::flush)
    return false;
  // From A's centre along its axis.
  const double centre = along.dot(pose_b.translation - pose_a.translation), sense = along.dot(other) >= 0 ? 0.5 : -0.5;
  const double ha = 0.5 * length_a, hb = 0.5 * length_b;
  const double lo = std::max(-ha, centre - hb), hi = std::min(ha, centre + hb);
  if (!(hi - lo > tolerance::flush * (length_a + length_b))) return false;
  const double depth = radius_a + radius_b - axes.distance;
  // The gap of the axes at A's centre, and how it changes along them: each end has its own place midway.
  const std::size_t first = contacts.size();
  for (const double end : {lo, hi}) {
    const Vec3 on_a = end * along;
    const Vec3 on_b = pose_b.translation - pose_a.translation + (end - centre) * (2 * sense) * other;
    const double here = radius_a + radius_b - axes.normal.dot(on_b - on_a);
    const Vec3 at = 0.5 * ((on_a + radius_a * axes.normal) + (on_b - radius_b * axes.normal));
    if (here < -margin - tolerance::alike * (length_a + length_b)) continue;
    contacts.push_back(
        {pose_a.translation + at, axes.normal, std::max(std::min(here, depth), -margin), end == lo ? 0u : 1u});
  }
  return contacts.size() > first;
}

void append_halfspace_manifold(const ConvexView& shape, const Pose& pose, const Vec3& normal, double offset,
                               double margin, std::vector<Contact>& contacts) {
  const FlatFeature f = best_face(shape, -normal);
  PatchPoint points[max_corners + 1];
  int count = 0;
  double deepest = -infinity;
  for (int i = 0; i < f.count; ++i) {
    const double depth = offset - normal.dot(f.corner[i]);
    if (depth < -margin - tolerance::alike * shape.size) continue;
    const double kept = std::max(depth, -margin);
    deepest = std::max(deepest, kept);
    points[count++] = {f.corner[i] + 0.5 * depth * normal, kept,
                       (f.id << 8 & 0x7fffff00u) | static_cast<std::uint32_t>(i), i == f.rim};
  }
  const Vec3 lowest = core_support(shape, -normal) - core_radius(shape) * normal;
  const double depth = offset - normal.dot(lowest);
  if (depth > deepest + tolerance::deeper * shape.size) {
    points[count++] = {lowest + 0.5 * depth * normal, depth, 0x80000000u};
  } else {
    // Of a disc's circle the corners stand for what lies between them.
    for (int i = 0; i < count; ++i)
      if (points[i].depth == deepest) points[i].depth = depth;
  }
  count = span_patch(points, count, normal, shape.size);
  append_points(points, count, pose, pose.rotation * normal, contacts);
}

}  // namespace tandem
