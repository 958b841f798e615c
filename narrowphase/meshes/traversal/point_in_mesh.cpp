// Exact test of a point in a closed mesh.
#include "meshes/traversal/point_in_mesh.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

#include "meshes/traversal/box_descent.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

using Rational = boost::multiprecision::cpp_rational;

int sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }
int sign(const Rational& x) { return x.sign(); }

// The ray from a point along the mesh's z axis. Where it hits an edge or a corner, the ray from the point moved by (e,
// e^2, 0) with an infinitesimal e counts: it crosses every edge on one side. If the point itself is not on the surface,
// the winding number there is the same (Edelsbrunner and Muecke, Simulation of simplicity, 1990).
class Ray {
 public:
  Ray(const MeshModel& mesh, const Pose& pose, const Vec3& p, const Pose& pose_p, const WorkLimit* limit)
      : mesh_(mesh), pose_(pose), pose_p_(pose_p), p_(p), meter_(limit) {
    const Mat3 inverse = pose.rotation.inverse();
    const Vec3 between = pose_p.translation - pose.translation;
    from_ = inverse * (pose_p.rotation * p + between);
    const bool same_frame = pose.rotation == pose_p.rotation && pose.translation == pose_p.translation;
    if (same_frame) from_ = p;
    delta_ = same_frame ? 0 : 64 * std::numeric_limits<double>::epsilon() * (3 * p.lpNorm<1>() + between.lpNorm<1>());
  }

  bool inside() {
    const Vec3 away = (from_ - mesh_.centre).cwiseAbs() - mesh_.half;
    const double slack = delta_ + tolerance::outward * (mesh_.centre.cwiseAbs() + mesh_.half).maxCoeff();
    if (away.maxCoeff() > slack) return false;
    // In units about the centre, like the boxes.
    const Vec3 at = (from_ - mesh_.centre) / mesh_.unit;
    const double pad = slack / mesh_.unit + tolerance::no_extent;
    int sum = 0;
    const auto reaches = [&](const LaneBoxes& boxes, std::uint32_t k) {
      const auto gap = [&](int axis) {
        return std::abs(static_cast<double>(boxes.mid[axis][k]) - at[axis]) - static_cast<double>(boxes.half[axis][k]);
      };
      const bool behind = at.z() > static_cast<double>(boxes.mid[2][k]) + static_cast<double>(boxes.half[2][k]) + pad;
      return !(behind || gap(0) > pad || gap(1) > pad);
    };
    const auto is_on_it = [&](std::uint32_t triangle) {
      const Crossing c = cross(mesh_.corners(triangle));
      sum += c.count;
      return c.on_surface;
    };
    if (visit_triangles(mesh_, meter_, reaches, is_on_it)) return true;
    return sum != 0;
  }

 private:
  using Point = std::array<Rational, 3>;
  struct Crossing {
    int count = 0;
    bool on_surface = false;
  };

  // The signs of a triangle relative to the point: of the volume, and of the three areas along z.
  struct Signs {
    int volume = 0;
    std::array<int, 3> area{};
    bool certain = true;
    bool on_it = false;
  };

  Crossing cross(const Corners& corners) {
    Signs s = filtered(corners);
    if (!s.certain) {
      s = exact(corners);
    }
    if (s.on_it) return {0, true};
    int turns = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = corners[k], &b = corners[(k + 1) % 3];
      // The area changes with the point by -(b - a).y e + (b - a).x e^2.
      int turn = s.area[k];
      if (turn == 0) turn = sign(a.y() - b.y());
      if (turn == 0) turn = sign(b.x() - a.x());
      turns += turn;
    }
    if (turns != 3 && turns != -3) return {};
    // Counterclockwise from above: its outside is up, and the volume is positive if it lies above the point.
    const bool above = turns > 0 ? s.volume > 0 : s.volume < 0;
    return {above ? turns / 3 : 0, false};
  }

  Signs filtered(const Corners& corners) const {
    const Vec3 a = corners[0] - from_, b = corners[1] - from_, c = corners[2] - from_;
    const double span = std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
    // Every difference has an error of at most delta plus its rounding.
    const double off = delta_ + tolerance::difference_rounding * span;
    const double flat = span * (8 * off + tolerance::area_rounding * span) + std::numeric_limits<double>::min();
    const double solid =
        span * span * (24 * off + tolerance::volume_rounding * span) + std::numeric_limits<double>::min();
    Signs s;
    const auto decide = [&](double x, double bound) {
      if (!(std::abs(x) > bound)) s.certain = false;
      return sign(x);
    };
    const auto area = [](const Vec3& u, const Vec3& v) { return u.x() * v.y() - u.y() * v.x(); };
    const std::array<double, 3> areas{area(a, b), area(b, c), area(c, a)};
    bool left = false, right = false;
    for (std::size_t k = 0; k < 3; ++k) {
      s.area[k] = decide(areas[k], flat);
      left = left || areas[k] > flat;
      right = right || areas[k] < -flat;
    }
    // Clearly beside the triangle: nothing else matters, and the point is not on it.
    if (left && right) {
      s.certain = true;
      return s;
    }
    s.volume = decide(a.dot(b.cross(c)), solid);
    return s;
  }

  // In the world: the rotation's determinant is positive, so signs are those of the mesh's frame.
  Signs exact(const Corners& corners) {
    constexpr int of_number = 128;  // rational numbers: some 10 us each
    std::array<Point, 3> v;
    for (std::size_t c = 0; c < 3; ++c)
      for (int i = 0; i < 3; ++i) {
        meter_.spend(of_number);
        Rational x = Rational(pose_.translation[i]) - Rational(pose_p_.translation[i]);
        for (int j = 0; j < 3; ++j)
          x += Rational(pose_.rotation(i, j)) * Rational(corners[c][j]) -
               Rational(pose_p_.rotation(i, j)) * Rational(p_[j]);
        v[c][static_cast<std::size_t>(i)] = x;
      }
    const auto det = [&](const Point& a, const Point& b, const Point& c) {
      meter_.spend(of_number);
      const Point n = crossed(b, c);
      return sign(a[0] * n[0] + a[1] * n[1] + a[2] * n[2]);
    };
    const Point up{Rational(pose_.rotation(0, 2)), Rational(pose_.rotation(1, 2)), Rational(pose_.rotation(2, 2))};
    Signs s;
    s.volume = det(v[0], v[1], v[2]);
    for (std::size_t k = 0; k < 3; ++k) s.area[k] = det(up, v[k], v[(k + 1) % 3]);
    meter_.spend(of_number);
    s.on_it = s.volume == 0 && holds_origin(v);
    return s;
  }

  static Point crossed(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }

  // True if the origin is in the closed triangle, in whose plane (or on whose line, if it has no area) it lies.
  static bool holds_origin(const std::array<Point, 3>& v) {
    // Each edge spans a parallelogram with the origin; for a point inside all three have the same orientation. If one
    // vanishes, the origin is on its line.
    const std::array<Point, 3> n{crossed(v[0], v[1]), crossed(v[1], v[2]), crossed(v[2], v[0])};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::array<int, 3> s{sign(n[0][i]), sign(n[1][i]), sign(n[2][i])};
      const auto [low, high] = std::minmax_element(s.begin(), s.end());
      if (*low < 0 && *high > 0) return false;
    }
    bool on_line = false;
    for (std::size_t k = 0; k < 3; ++k)
      if (sign(n[k][0]) == 0 && sign(n[k][1]) == 0 && sign(n[k][2]) == 0) {
        if (between(v[k], v[(k + 1) % 3])) return true;
        on_line = true;
      }
    return !on_line;
  }

  // True if the origin, on the line of a and b, is between them.
  static bool between(const Point& a, const Point& b) {
    for (std::size_t i = 0; i < 3; ++i)
      if (sign(a[i]) * sign(b[i]) > 0) return false;
    return true;
  }

  const MeshModel& mesh_;
  const Pose &pose_, &pose_p_;
  const Vec3 p_;
  WorkMeter meter_;
  Vec3 from_;  // the point in the mesh's frame, within delta_ in every coordinate
  double delta_;
};

}  // namespace

bool is_inside(const MeshModel& mesh, const Pose& pose, const Vec3& p, const Pose& pose_p, const WorkLimit* limit) {
  // Usually the point is far from the box, and a rotation's transpose, its inverse to 6e-6, suffices.
  const Vec3 between = pose_p.rotation * p + (pose_p.translation - pose.translation);
  const Vec3 away = (pose.rotation.transpose() * between - mesh.centre).cwiseAbs() - mesh.half;
  if (away.maxCoeff() > tolerance::askew_in_floats * (between.lpNorm<1>() + p.lpNorm<1>() + mesh.centre.lpNorm<1>()))
    return false;
  return Ray(mesh, pose, p, pose_p, limit).inside();
}

bool is_inside(const MeshModel& mesh, const Vec3& p, const WorkLimit* limit) {
  const Pose same;
  return Ray(mesh, same, p, same, limit).inside();
}

}  // namespace tandem
