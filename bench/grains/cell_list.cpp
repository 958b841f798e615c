#include "grains/cell_list.h"

#include <algorithm>
#include <cmath>

namespace tandem::bench {
namespace {

class CellList final : public SceneDetector {
 public:
  explicit CellList(const Scene& scene) {
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      const Shape& shape = scene.shape_of(i);
      if (shape.kind() == ShapeKind::halfspace)
        planes_.push_back(
            {i, scene.poses()[i].rotation * shape.normal(), shape.offset(), scene.poses()[i].translation});
      else
        bodies_.push_back(i), radius_.push_back(shape.radius());
    }
    edge_ = 2 * *std::max_element(radius_.begin(), radius_.end());
    balls_.resize(bodies_.size());
    cell_.resize(bodies_.size());
  }

  std::string name() const override { return "cell list"; }

  // Forty lines.
  void detect(const Scene& scene) override {
    pairs_.clear();
    const auto poses = scene.poses();
    Vec3 lo = poses[bodies_[0]].translation, hi = lo;
    for (const std::uint32_t body : bodies_) {
      lo = lo.cwiseMin(poses[body].translation);
      hi = hi.cwiseMax(poses[body].translation);
    }
    long side[3];
    for (int k = 0; k < 3; ++k) side[k] = static_cast<long>((hi[k] - lo[k]) / edge_) + 1;
    const long row = side[0], layer = side[0] * side[1];
    first_.assign(static_cast<std::size_t>(layer * side[2]) + 1, 0);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Vec3& x = poses[bodies_[i]].translation;
      long at[3];
      for (int k = 0; k < 3; ++k) at[k] = static_cast<long>((x[k] - lo[k]) / edge_);
      ++first_[cell_[i] = static_cast<std::size_t>(at[0] + row * at[1] + layer * at[2])];
    }
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    for (std::size_t i = bodies_.size(); i-- > 0;)
      balls_[--first_[cell_[i]]] = {poses[bodies_[i]].translation, radius_[i], bodies_[i]};
    for (long z = 0; z < side[2]; ++z)
      for (long y = 0; y < side[1]; ++y)
        for (long dz = 0; dz <= 1; ++dz)
          for (long dy = dz == 0 ? 0 : -1; dy <= 1; ++dy) {
            if (z + dz >= side[2] || y + dy < 0 || y + dy >= side[1]) continue;
            for (long x = 0; x < side[0]; ++x) {
              const long c = x + row * y + layer * z, others = row * (y + dy) + layer * (z + dz);
              const bool own_row = dz == 0 && dy == 0;
              const std::size_t end = first_[static_cast<std::size_t>(others + std::min(x + 1, row - 1)) + 1];
              for (std::size_t i = first_[static_cast<std::size_t>(c)]; i < first_[static_cast<std::size_t>(c) + 1];
                   ++i)
                for (std::size_t j = own_row ? i + 1 : first_[static_cast<std::size_t>(others + std::max(x - 1, 0L))];
                     j < end; ++j) {
                  const Vec3 d = balls_[j].centre - balls_[i].centre;
                  const double length2 = d.squaredNorm(), reach = balls_[i].radius + balls_[j].radius;
                  if (length2 <= reach * reach) put(balls_[i].body, balls_[j].body, reach - std::sqrt(length2));
                }
            }
          }
    for (const Plane& plane : planes_)
      for (const Ball& ball : balls_) {
        const double gap = plane.normal.dot(ball.centre - plane.origin) - plane.offset - ball.radius;
        if (gap <= 0) put(plane.body, ball.body, -gap);
      }
  }

  std::vector<TouchingPair> found() const override { return pairs_; }

 private:
  struct Ball {
    Vec3 centre;
    double radius;
    std::uint32_t body;
  };
  struct Plane {
    std::uint32_t body;
    Vec3 normal;
    double offset;
    Vec3 origin;
  };

  void put(std::uint32_t a, std::uint32_t b, double depth) {
    pairs_.push_back({std::min(a, b), std::max(a, b), 1, depth});
  }

  double edge_ = 0;  // of a cell: the largest diameter
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> bodies_;
  std::vector<double> radius_;
  std::vector<std::size_t> cell_, first_;  // of each sphere; of each cell, and the end
  std::vector<Ball> balls_;                // cell by cell
  std::vector<TouchingPair> pairs_;
};

}  // namespace

std::unique_ptr<SceneDetector> cell_list_detector(const Scene& scene) { return std::make_unique<CellList>(scene); }

}  // namespace tandem::bench
