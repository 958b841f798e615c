// Cell lists as contestants of the bench of grains.
#include "grains/cell_list.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem::bench {
namespace {

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

  double gap(const Ball& ball) const { return normal.dot(ball.centre - origin) - offset - ball.radius; }
};

/// Spheres sorted by cells, and half-spaces.
class Cells {
 public:
  explicit Cells(const Scene& scene) {
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      const Shape& shape = scene.shape_of(i);
      if (shape.kind() == ShapeKind::halfspace)
        planes_.push_back(
            {i, scene.poses()[i].rotation * shape.normal(), shape.offset(), scene.poses()[i].translation});
      else
        bodies_.push_back(i), radius_.push_back(shape.radius());
    }
    if (!planes_.empty() && planes_.back().body > bodies_.front())
      throw std::invalid_argument("cell list: half-spaces must have lower indices than spheres");
    edge_ = 2 * *std::max_element(radius_.begin(), radius_.end());
    balls_.resize(bodies_.size());
    cell_.resize(bodies_.size());
  }
  std::span<const Plane> planes() const { return planes_; }

  // Finds contacts, in forty lines; calls `meet(ball, ball)` and `land(plane, ball, gap)` for those that touch.
  template <class Meet, class Land>
  void detect(const Scene& scene, const Meet& meet, const Land& land) {
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
                  const double length2 = (balls_[j].centre - balls_[i].centre).squaredNorm();
                  const double reach = balls_[i].radius + balls_[j].radius;
                  if (length2 <= reach * reach) meet(balls_[i], balls_[j], length2, reach);
                }
            }
          }
    for (const Plane& plane : planes_)
      for (const Ball& ball : balls_)
        if (const double gap = plane.gap(ball); gap <= 0) land(plane, ball, gap);
  }

 private:
  double edge_ = 0;  // edge of a cell: the largest diameter
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> bodies_;
  std::vector<double> radius_;
  std::vector<std::size_t> cell_, first_;  // the cell of each sphere; the first sphere of each cell, and the end
  std::vector<Ball> balls_;                // cell by cell
};

/// A detector that reports pairs in no order, with the depth of each.
class DepthsAlone final : public SceneDetector {
 public:
  explicit DepthsAlone(const Scene& scene) : cells_(scene) {}
  std::string name() const override { return "cells, depths"; }
  void detect(const Scene& scene) override {
    pairs_.clear();
    cells_.detect(
        scene,
        [&](const Ball& a, const Ball& b, double length2, double reach) {
          put(a.body, b.body, reach - std::sqrt(length2));
        },
        [&](const Plane& plane, const Ball& ball, double gap) { put(plane.body, ball.body, -gap); });
  }
  std::vector<TouchingPair> found() const override { return pairs_; }

 private:
  void put(std::uint32_t a, std::uint32_t b, double depth) {
    pairs_.push_back({std::min(a, b), std::max(a, b), 1, depth});
  }

  Cells cells_;
  std::vector<TouchingPair> pairs_;
};

/// A detector that makes the same list as tandem, to the last bit: sorted pairs, answers and contacts. Pairs are sorted
/// before their answers are written, each once and in its final place.
class WholeList final : public SceneDetector {
 public:
  explicit WholeList(const Scene& scene) : cells_(scene), placed_(scene.indices()), next_(scene.indices() + 1) {}
  std::string name() const override { return "cells, whole list"; }

  void detect(const Scene& scene) override {
    touching_.clear();
    const auto put = [&](std::uint32_t a, std::uint32_t b) {
      touching_.push_back({std::min(a, b), std::max(a, b)});
      ++next_[touching_.back().a + 1];
    };
    std::fill(next_.begin(), next_.end(), 0u);
    cells_.detect(
        scene,
        [&](const Ball& a, const Ball& b, double, double) {
          placed_[a.body] = a;
          placed_[b.body] = b;
          put(a.body, b.body);
        },
        [&](const Plane& plane, const Ball& ball, double) {
          placed_[ball.body] = ball;
          put(plane.body, ball.body);
        });
    sort();
    list_.pairs.resize(touching_.size());
    list_.contacts.resize(touching_.size());
    for (std::size_t i = 0; i < touching_.size(); ++i) answer(static_cast<std::uint32_t>(i));
  }

  std::vector<TouchingPair> found() const override {
    std::vector<TouchingPair> out;
    for (const PairResult& pair : list_.pairs) out.push_back({pair.a, pair.b, 1, -pair.answer.signed_distance});
    return out;
  }
  std::uint64_t list_hash() const override { return hash(list_); }

 private:
  /// Sorts by a counting sort of the first bodies, then by insertion.
  void sort() {
    for (std::size_t a = 1; a < next_.size(); ++a) next_[a] += next_[a - 1];  // now: where the pairs of a begin
    sorted_.resize(touching_.size());
    for (const Pair& pair : touching_) sorted_[next_[pair.a]++] = pair.b;
    std::uint32_t first = 0;
    for (std::uint32_t a = 0; a + 1 < next_.size(); first = next_[a++]) {
      const auto begin = sorted_.begin() + first, end = sorted_.begin() + next_[a];
      if (end - begin > 32)
        std::sort(begin, end);
      else
        for (auto at = begin; at != end; ++at) {
          const std::uint32_t b = *at;
          auto to = at;
          for (; to != begin && to[-1] > b; --to) *to = to[-1];
          *to = b;
        }
      for (auto at = begin; at != end; ++at) touching_[static_cast<std::size_t>(at - sorted_.begin())] = {a, *at};
    }
  }

  void answer(std::uint32_t i) {
    const Pair pair = touching_[i];
    PairResult& result = list_.pairs[i];
    result = {pair.a, pair.b, i, 1, {}};
    PairAnswer& answer = result.answer;
    const Ball& b = placed_[pair.b];
    if (pair.a < cells_.planes().size()) {
      const Plane& plane = cells_.planes()[pair.a];
      answer.signed_distance = plane.gap(b);
      answer.normal = plane.normal;
      answer.point_b = b.centre - b.radius * plane.normal;
      answer.point_a = answer.point_b - answer.signed_distance * plane.normal;
    } else {
      const Ball& a = placed_[pair.a];
      const Vec3 between = b.centre - a.centre;
      const double length = std::sqrt(between.squaredNorm());
      answer.signed_distance = length - (a.radius + b.radius);
      answer.normal = between / length;
      answer.point_a = a.centre + a.radius * answer.normal;
      answer.point_b = b.centre - b.radius * answer.normal;
    }
    answer.collide = true;
    list_.contacts[i] = {0.5 * (answer.point_a + answer.point_b), answer.normal, -answer.signed_distance, 0};
  }

  Cells cells_;
  std::vector<Pair> touching_;
  std::vector<Ball> placed_;                  // a body
  std::vector<std::uint32_t> next_, sorted_;  // for each body: where its next pair goes; second bodies
  ContactList list_;
};

}  // namespace

SceneDetectors cell_list_detectors(const Scene& scene) {
  SceneDetectors out;
  out.push_back(std::make_unique<DepthsAlone>(scene));
  out.push_back(std::make_unique<WholeList>(scene));
  return out;
}

}  // namespace tandem::bench
