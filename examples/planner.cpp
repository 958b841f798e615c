// A planner's loop: an arm of three links among obstacles. Random configurations are checked in one batch, free ones
// near each other are joined by motions, and the clearance of the path found is printed. Exit code 1 if a verdict
// differs from that of single pairs.
#include <algorithm>
#include <array>
#include <cstdio>
#include <random>
#include <vector>

#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace {

using tandem::Pose;
using tandem::Vec3;
using Angles = std::array<double, 3>;

constexpr double link_length = 0.4;

/// The links are end to end from the origin, each rotated about y or z relative to the one before.
void place(const Angles& angles, std::vector<Pose>& poses) {
  Pose at;
  for (std::size_t j = 0; j < angles.size(); ++j) {
    const Vec3 axis = j % 2 == 0 ? Vec3::UnitY() : Vec3::UnitZ();
    at.rotation = at.rotation * Eigen::AngleAxisd(angles[j], axis).toRotationMatrix();
    const Vec3 along = at.rotation.col(2) * link_length;
    poses.push_back({at.rotation, at.translation + along / 2});
    at.translation += along;
  }
}

tandem::Scene obstacles() {
  tandem::Scene scene;
  const auto floor = scene.add_shape(tandem::HalfSpace{{0, 0, 1}, -0.3});
  const auto post = scene.add_shape(tandem::Cylinder{0.1, 1.5});
  const auto table = scene.add_shape(tandem::Box{{0.6, 0.6, 0.05}});
  scene.add_body({.shape = floor, .is_static = true});
  scene.add_body({.shape = post, .pose = Pose::at(0.7, 0.3, 0.4), .is_static = true});
  scene.add_body({.shape = table, .pose = Pose::at(-0.6, 0, 0.2), .is_static = true});
  return scene;
}

}  // namespace

int main() {
  const tandem::Scene scene = obstacles();
  const tandem::SceneQueries queries(scene);
  const tandem::Shape link = tandem::Capsule{0.06, link_length};
  const std::vector<tandem::Shape> links(3, link);
  tandem::PairTable self(3, 3, false);
  self.set(0, 2, true);  // neighbours touch at their joint

  std::mt19937 random(1);
  std::uniform_real_distribution<double> any_angle(-2.4, 2.4);
  std::vector<Angles> drawn(1000);
  std::vector<Pose> poses;
  for (Angles& angles : drawn) {
    for (double& angle : angles) angle = any_angle(random);
    place(angles, poses);
  }
  std::vector<tandem::Verdict> verdicts(drawn.size());
  queries.check(links, poses, self, verdicts);
  std::vector<Angles> free;
  for (std::size_t i = 0; i < drawn.size(); ++i)
    if (verdicts[i] == tandem::Verdict::free) free.push_back(drawn[i]);

  // Motions of 20 configurations from each free one to the next, in one batch.
  constexpr std::size_t a_motion = 20;
  poses.clear();
  for (std::size_t i = 0; i + 1 < free.size(); ++i)
    for (std::size_t k = 0; k < a_motion; ++k) {
      Angles between;
      for (std::size_t j = 0; j < 3; ++j)
        between[j] = free[i][j] + (free[i + 1][j] - free[i][j]) * static_cast<double>(k) / (a_motion - 1);
      place(between, poses);
    }
  std::vector<tandem::Verdict> motions(free.size() - 1);
  tandem::BatchOptions options;
  options.configurations_a_motion = a_motion;
  queries.check(links, poses, self, motions, options);
  std::size_t joined = 0;
  for (const tandem::Verdict verdict : motions) joined += verdict == tandem::Verdict::free;

  std::vector<double> clearances(poses.size() / 3);
  queries.clearance(links, poses, self, clearances);
  std::printf("%zu of %zu configurations are free, %zu of %zu motions\n", free.size(), drawn.size(), joined, motions.size());

  // The verdicts of single pairs for the first motion's first configuration.
  const tandem::NarrowPhase narrow;
  double least = narrow.solve(links[0], poses[0], links[2], poses[2], tandem::Request::distance).signed_distance;
  for (std::size_t j = 0; j < 3; ++j)
    if (const auto hit = queries.nearest(links[j], poses[j])) least = std::min(least, hit->answer.signed_distance);
  std::printf("clearance of the first: %.4f m\n", clearances[0]);
  if (least != clearances[0] || !(least > 0)) {
    std::printf("WRONG: single pairs say %.17g\n", least);
    return 1;
  }
  return 0;
}
