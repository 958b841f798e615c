// How deep points of one mesh lie in another, measured along a direction.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "manifold/patch_collector.h"
#include "meshes/contacts/crossing_patches.h"
#include "tolerances.h"

namespace tandem {

/// How far a point of one mesh lies beyond the other's surface, measured along `n` (from A to B); negative if nothing
/// of that surface is there.
class DepthProbe {
 public:
  DepthProbe(const Facets& facets, const Vec3& n, const WorkLimit* limit, Memory memory)
      : n_(n), flats_{List<Flat>(memory), List<Flat>(memory)} {
    u_ = uncommon(n).normalized();
    v_ = n.cross(u_);
    WorkMeter meter(limit);
    for (const std::size_t of_a : {std::size_t{1}, std::size_t{0}}) {
      flats_[of_a].reserve(std::min(facets[of_a].size(), usual_flats));
      for (const Facet& facet : facets[of_a]) {
        meter.spend();
        const auto& p = facet.p;
        // Only the sides that face each other, not those along n but for what little a pose is off.
        if (!(facet.n.dot(n) > tolerance::flush)) continue;
        Flat f;
        for (std::size_t k = 0; k < 3; ++k) f.x[k] = u_.dot(p[k]), f.y[k] = v_.dot(p[k]), f.z[k] = n.dot(p[k]);
        const auto [low_x, high_x] = std::minmax({f.x[0], f.x[1], f.x[2]});
        const auto [low_y, high_y] = std::minmax({f.y[0], f.y[1], f.y[2]});
        const double slack = 4 * edge * (high_x - low_x + high_y - low_y) +
                             tolerance::place_rounding_of_nearest * (std::abs(f.x[0]) + std::abs(f.y[0]));
        f.low_x = low_x - slack, f.high_x = high_x + slack, f.low_y = low_y - slack, f.high_y = high_y + slack;
        flats_[of_a].push_back(f);
      }
    }
  }

  double operator()(const Candidate& c, WorkMeter& meter) const {
    const double x = u_.dot(c.point), y = v_.dot(c.point), z = n_.dot(c.point);
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t tried = 0;
    for (const Flat& f : flats_[c.of_a ? 0 : 1]) {
      if (tried++ % 32 == 0) meter.spend();
      if (!(x >= f.low_x && x <= f.high_x && y >= f.low_y && y <= f.high_y)) continue;
      const double ax = f.x[1] - f.x[0], ay = f.y[1] - f.y[0], bx = f.x[2] - f.x[0], by = f.y[2] - f.y[0];
      const double det = ax * by - ay * bx;
      if (det == 0) continue;
      const double px = x - f.x[0], py = y - f.y[0];
      const double s = (px * by - py * bx) / det, t = (ax * py - ay * px) / det;
      if (!(s >= -edge && t >= -edge && s + t <= 1 + edge)) continue;
      const double height = f.z[0] + s * (f.z[1] - f.z[0]) + t * (f.z[2] - f.z[0]);
      const double depth = c.of_a ? z - height : height - z;
      if (depth >= 0) nearest = std::min(nearest, depth);
    }
    return std::isfinite(nearest) ? nearest : -1;
  }

  const Vec3& u() const { return u_; }
  const Vec3& v() const { return v_; }

 private:
  static constexpr double edge = tolerance::on_edge;  // a point on an edge belongs to both sides
  static constexpr std::size_t usual_flats = 64;
  struct Flat {
    double low_x, high_x, low_y, high_y;  // wide enough for that
    std::array<double, 3> x, y, z;
  };
  Vec3 n_, u_, v_;
  std::array<List<Flat>, 2> flats_;
};

}  // namespace tandem
