// The face, edge or point of a convex shape in a direction.
#include "manifold/flat_feature.h"

#include <bit>
#include <optional>
#include <tuple>

#include "shapes/highest_faces.h"
#include "shapes/hull.h"
#include "shapes/triangle_height.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// The corners of the polygon that represents a circle, counterclockwise from the x axis.
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

/// The directions from the middle of a face in which another feature lies, within a quarter turn of each other: from
/// `lo` to `hi`, tangents of angles from the unit vector (x, y). Counterclockwise coordinates in the face's plane.
struct Sector {
  double x, y, lo, hi;
};

/// The sector of a feature's corners, in coordinates that `place` gives, widened by a quarter of its size; none if it
/// is a point, or lies around the middle.
template <class Place>
std::optional<Sector> sector_of(const FlatFeature& other, const Place& place) {
  double at[max_corners][2], x = 0, y = 0;
  for (int i = 0; i < other.count; ++i) {
    place(other.corner[i], at[i]);
    x += at[i][0], y += at[i][1];
  }
  x /= other.count, y /= other.count;
  const double distance = std::sqrt(x * x + y * y);
  if (!(distance > 0)) return std::nullopt;
  Sector s{x / distance, y / distance, infinity, -infinity};
  double size2 = 0;
  for (int i = 0; i < other.count; ++i) {
    const double along = s.x * at[i][0] + s.y * at[i][1], across = s.x * at[i][1] - s.y * at[i][0];
    if (!(along > std::abs(across))) return std::nullopt;
    s.lo = std::min(s.lo, across / along), s.hi = std::max(s.hi, across / along);
    size2 = std::max(size2, (at[i][0] - x) * (at[i][0] - x) + (at[i][1] - y) * (at[i][1] - y));
  }
  if (!(size2 > 0)) return std::nullopt;
  constexpr double widest = 0.5;  // of a feature whose corners are mostly at one end
  const double wider = std::min(0.25 * std::sqrt(size2) / distance, widest);
  s.lo -= wider, s.hi += wider;
  return s;
}

constexpr int corners_beside = 3, corners_in_sector = max_corners - corners_beside;

/// The polygon of a circle whose corners are in the sector, but for three.
CirclePolygon polygon_in(const Sector& s) {
  CirclePolygon p;
  for (int i = 0; i < corners_in_sector; ++i) {
    const double t = s.lo + (s.hi - s.lo) * i / (corners_in_sector - 1), length = std::sqrt(1 + t * t);
    p.x[i] = (s.x - t * s.y) / length, p.y[i] = (s.y + t * s.x) / length;
  }
  const double beside[corners_beside][2] = {{-s.y, s.x}, {-s.x, -s.y}, {s.y, -s.x}};
  for (int i = 0; i < corners_beside; ++i)
    p.x[corners_in_sector + i] = beside[i][0], p.y[corners_in_sector + i] = beside[i][1];
  p.x[max_corners] = p.x[0], p.y[max_corners] = p.y[0];
  return p;
}

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

/// The deepest point (unit: x, y) of a disc that leans by rho, the sine of the angle. The less it leans, the farther
/// this point moves when the pose changes a little; therefore it is rounded to a grid so coarse that the depth there is
/// within 1.25e-9 of the radius of the greatest, and mostly stays.
void find_lowest_of_circle(double rho, double& x, double& y) {
  if (rho >= tolerance::steady_lean) return;
  // By tangents from the nearest of eight directions; these are such that no likely angle lies halfway between two.
  const double ax = std::abs(x), ay = std::abs(y);
  const bool diagonal = std::min(ax, ay) > 0.41421356 * std::max(ax, ay);
  const double cx = diagonal || ax > ay ? std::copysign(1.0, x) : 0.0;
  const double cy = diagonal || ay >= ax ? std::copysign(1.0, y) : 0.0;
  const double step = power_below_root(tolerance::lowest_point_lacks2 / rho);  // rho step^2 / 8 is the missing depth
  constexpr double to_whole = 0x1.8p52;
  const double t = ((cx * y - cy * x) / (cx * x + cy * y) / step + to_whole - to_whole) * step;
  const double length = std::sqrt((cx * cx + cy * cy) * (1 + t * t));
  x = (cx - t * cy) / length;
  y = (cy + t * cx) / length;
}

/// Adds the polygon of a circle. It is fixed to the body, so that its corners stay while the deepest point moves; the
/// deepest point replaces the nearest corner. So the deepest point, the one opposite and those to either side nearly
/// form a square, which supports a body equally well however it leans: with three fixed corners and the deepest point
/// anywhere between them, stacks swayed for ever. A disc that counts as flat has no deepest point.
///
/// For another feature in a sector, the polygon's corners are there, and move with it: between 16 all around, bodies
/// smaller than a fiftieth of the radius would have no contacts at the rim.
void add_circle(FlatFeature& f, double radius, double z, const Vec3& towards, bool counterclockwise,
                const FlatFeature* other) {
  const double width = counterclockwise ? radius : -radius;
  const auto place = [&](const Vec3& p, double* at) { at[0] = p[0], at[1] = std::copysign(1.0, width) * p[1]; };
  std::optional<CirclePolygon> own;
  if (const auto sector = other != nullptr ? sector_of(*other, place) : std::nullopt) own = polygon_in(*sector);
  const CirclePolygon& polygon = own ? *own : circle;
  for (int i = 0; i < max_corners; ++i) f.add({radius * polygon.x[i], width * polygon.y[i], z});
  const double rho = std::sqrt(towards[0] * towards[0] + towards[1] * towards[1]);
  if (!(rho > tolerance::alike)) return;
  double x = towards[0] / rho, y = std::copysign(1.0, width) * towards[1] / rho;
  find_lowest_of_circle(rho, x, y);
  // By distances: cosines of the corners in a small sector are all 1.
  const auto distance2 = [&](int i) {
    return (polygon.x[i] - x) * (polygon.x[i] - x) + (polygon.y[i] - y) * (polygon.y[i] - y);
  };
  const int first = own ? 0 : corner_before(x, y), last = own ? max_corners - 1 : first + 1;
  int nearest = first;
  for (int i = first + 1; i <= last; ++i)
    if (distance2(i) < distance2(nearest)) nearest = i;
  f.lowest = nearest % max_corners;
  f.corner[f.lowest] = {radius * x, width * y, z};
}

/// The face most aligned with d (unit); of equals the first.
std::size_t facing_most(const Hull& hull, const Vec3& d) {
  if (!hull.normals.empty()) return face_kernel()(hull, d.data());
  std::size_t best = 0;
  double most = -infinity;
  const auto compare = [&](std::size_t i) {
    if (const double along = hull.faces[i].normal.dot(d); along > most) most = along, best = i;
  };
  if (hull.face_table.faces == 0) {
    for (std::size_t i = 0; i < hull.faces.size(); ++i) compare(i);
    return best;
  }
  for_each_face(faces_along(hull.face_table, d), compare);
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

/// For a capsule, the line of its side; unless it lies flat, its farthest point is beyond an end of that line.
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

/// For a cylinder, a disc as a polygon, else a line of its lateral surface.
FlatFeature face_of_cylinder(const ConvexView& v, const Vec3& d, const FlatFeature* other) {
  FlatFeature f;
  const double h = 0.5 * v.param[1], rho = std::sqrt(d[0] * d[0] + d[1] * d[1]);
  if (std::abs(d[2]) > rho) {
    f.normal = {0, 0, std::copysign(1.0, d[2])};
    add_circle(f, v.param[0], std::copysign(h, d[2]), d, d[2] > 0, other);
    f.id = d[2] > 0 ? 1 : 2;
  } else {
    const double x = v.param[0] * d[0] / rho, y = v.param[0] * d[1] / rho;
    f.add({x, y, h});
    f.add({x, y, -h});
  }
  return f;
}

/// For a cone, its disc, else a line of its lateral surface.
FlatFeature face_of_cone(const ConvexView& v, const Vec3& d, const FlatFeature* other) {
  FlatFeature f;
  const double r = v.param[0], length = v.param[1], rho = std::sqrt(d[0] * d[0] + d[1] * d[1]);
  const double side = (length * rho + r * d[2]) / std::sqrt(r * r + length * length);
  if (-d[2] >= side) {
    f.normal = {0, 0, -1};
    add_circle(f, r, -0.5 * length, d, false, other);
    f.id = 1;
  } else {
    f.add({0, 0, 0.5 * length});
    if (rho > shortest_squared) f.add({r * d[0] / rho, r * d[1] / rho, -0.5 * length});
  }
  return f;
}

/// Adds corners first to last - 1 of a loop of numbers, thinned evenly to `most`, with the first.
template <class Corner>
void add_thinned(FlatFeature& f, std::uint32_t first, std::uint32_t last, std::uint32_t most, const Corner& corner) {
  const std::uint32_t count = last - first, kept = std::min(count, most);
  for (std::uint32_t i = 0; i < kept; ++i) f.add(corner(first + i * count / kept));
}

/// Adds the corners of a face with too many: those in the sector of the other feature and beside it, else evenly.
void add_many_corners(FlatFeature& f, const ConvexView& v, const Hull::Face& face, const FlatFeature* other) {
  const std::uint32_t* const loop = &v.hull->loop[face.first];
  const auto corner = [&](std::uint32_t i) -> const Vec3& { return v.vertices[loop[i % face.count]]; };
  if (other == nullptr) return add_thinned(f, 0, face.count, max_corners, corner);
  Vec3 middle = Vec3::Zero();
  for (std::uint32_t i = 0; i < face.count; ++i) middle += corner(i);
  middle /= face.count;
  const Vec3 along = any_perpendicular(face.normal), across = face.normal.cross(along);
  const auto place = [&](const Vec3& p, double* at) { at[0] = along.dot(p - middle), at[1] = across.dot(p - middle); };
  const auto sector = sector_of(*other, place);
  if (!sector) return add_thinned(f, 0, face.count, max_corners, corner);
  // The corners around: before the sector, in it, after it.
  const auto side = [&](std::uint32_t i) {
    double at[2];
    place(corner(i), at);
    const double x = sector->x * at[0] + sector->y * at[1], y = sector->x * at[1] - sector->y * at[0];
    return x <= 0 ? (y < 0 ? -1 : 1) : y < sector->lo * x ? -1 : y > sector->hi * x ? 1 : 0;
  };
  std::uint32_t from = 0;
  while (from < face.count && !(side(from) < 0 && side(from + 1) >= 0)) ++from;
  std::uint32_t to = from + 1;
  while (to < from + face.count && side(to) == 0) ++to;
  add_thinned(f, from, to, corners_in_sector - 1, corner);
  f.add(corner(to));
  add_thinned(f, to + 1, from + face.count, corners_beside, corner);
}

/// For a hull or triangle, a face; for one without area the segment or point.
FlatFeature face_of_hull(const ConvexView& v, const Vec3& d, const FlatFeature* other) {
  FlatFeature f;
  if (v.hull != nullptr && !v.hull->faces.empty()) {
    const std::size_t best = facing_most(*v.hull, d);
    const Hull::Face& face = v.hull->faces[best];
    f.normal = face.normal;
    f.id = static_cast<std::uint32_t>(best);
    if (face.count > max_corners)
      add_many_corners(f, v, face, other);
    else
      for (std::uint32_t i = 0; i < face.count; ++i) f.add(v.vertices[v.hull->loop[face.first + i]]);
    return f;
  }
  if (v.vertices.size() == 3) {
    const Vec3 &p = v.vertices[0], &q = v.vertices[1], &r = v.vertices[2];
    const Vec3 n = normal_of(q - p, r - q, p - r);
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

}  // namespace

FlatFeature best_face(const ConvexView& v, const Vec3& d, const FlatFeature* other) {
  switch (v.kind) {
    case ShapeKind::box:
      return face_of_box(v, d);
    case ShapeKind::capsule:
      return face_of_capsule(v, d);
    case ShapeKind::cylinder:
      return face_of_cylinder(v, d, other);
    case ShapeKind::cone:
      return face_of_cone(v, d, other);
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return face_of_hull(v, d, other);
    case ShapeKind::sphere:
    case ShapeKind::ellipsoid:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  FlatFeature f;
  f.add(core_support(v, d) + core_radius(v) * d);
  return f;
}

bool has_more_corners(const ConvexView& v, const FlatFeature& face) {
  return face.count == max_corners && (v.hull == nullptr || v.hull->faces[face.id].count > max_corners);
}

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
    case ShapeKind::sphere:
    case ShapeKind::ellipsoid:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  return f;
}

void move(FlatFeature& f, const RelativePose& pose) {
  for (int i = 0; i < f.count; ++i) f.corner[i] = pose.rotation * f.corner[i] + pose.translation;
  f.normal = pose.rotation * f.normal;
  if (f.radius > 0) {
    f.ball = pose.rotation * f.ball + pose.translation;
    f.end = pose.rotation * f.end;
  }
}

}  // namespace tandem
