// Exact test of a point in a closed mesh.
#include "meshes/traversal/point_in_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "meshes/traversal/box_descent.h"
#include "shapes/work_meter.h"
#include "tolerances.h"
#include "triangles/exact_triangles.h"

namespace tandem {
namespace {

int sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

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
      const Crossing c = cross(joined_corners(triangle));
      sum += c.count;
      return c.on_surface;
    };
    if (visit_triangles(mesh_, meter_, reaches, is_on_it)) return true;
    return sum != 0;
  }

 private:
  struct Crossing {
    int count = 0;
    bool on_surface = false;
  };

  // Vertices that are joined although they differ by rounding are one here, so that the surface is closed exactly.
  Corners joined_corners(std::uint32_t triangle) const {
    const auto& t = mesh_.triangles[triangle];
    const auto vertex = [&](std::uint32_t v) -> const Vec3& { return mesh_.vertices[mesh_.representative(v)]; };
    return {vertex(t[0]), vertex(t[1]), vertex(t[2])};
  }

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
    constexpr int of_integers = 8;  // some 1 us; 20 us where numbers differ by a factor of 1e300
    meter_.spend(of_integers);
    if (!places_) places_.emplace(pose_, pose_p_);
    // The ray's direction is the difference of two places. In the mesh's unit its exponent is near those of the
    // corners.
    const Vec3 up = mesh_.unit * Vec3::UnitZ();
    return places_->visit(
        std::array<Vec3, 5>{corners[0], corners[1], corners[2], Vec3::Zero(), up}, std::array<Vec3, 1>{p_},
        []<class N>(const std::array<predicates::Point<N>, 5>& a, const std::array<predicates::Point<N>, 1>& b) {
          using predicates::operator-;
          const predicates::Point<N>&p = b[0], ray = a[4] - a[3];
          const std::array<predicates::Point<N>, 3> v{a[0] - p, a[1] - p, a[2] - p};
          Signs s;
          s.volume = predicates::dot_sign(predicates::cross(v[1], v[2]), v[0]);
          for (std::size_t k = 0; k < 3; ++k)
            s.area[k] = predicates::dot_sign(predicates::cross(v[k], v[predicates::next_corner(k)]), ray);
          predicates::ExactTriangle<N> triangle;
          triangle.p = {a[0], a[1], a[2]};
          s.on_it = s.volume == 0 && triangle.meets(p, p, 0, 0);
          return s;
        });
  }

  const MeshModel& mesh_;
  const Pose &pose_, &pose_p_;
  const Vec3 p_;
  WorkMeter meter_;
  std::optional<ExactPlaces> places_;  // made on first use
  Vec3 from_;                          // the point in the mesh's frame, within delta_ in every coordinate
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
