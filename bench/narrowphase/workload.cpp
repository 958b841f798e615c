// Makes the workloads of the narrow-phase bench.
#include "workload.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <optional>

namespace tandem::bench {
namespace {

template <typename Make>
void fill(Workload& work, std::size_t n, const Make& make) {
  std::vector<std::optional<reference::PosedPair>> pairs(n);
  work.truths.resize(n);
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    const reference::PosedPair& p = pairs[i].emplace(make(i));
    work.truths[i] = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
  });
  for (auto& pair : pairs) work.pairs.push_back(std::move(*pair));
}

constexpr std::size_t motion_steps = 20;

std::size_t tracks_of(std::size_t n) { return std::max<std::size_t>(1, n / motion_steps); }

reference::PosedPair motion_pair(reference::PairKind kind, std::size_t tracks, std::size_t i) {
  reference::PosedPair pair = reference::make_pair(kind, reference::PairClass::separated, i % tracks);
  const auto step = static_cast<double>(i / tracks);
  // Towards A, but not straight at its centre.
  const Vec3 between = pair.pose_a.translation - pair.pose_b.translation;
  const Vec3 axis = pair.pose_b.rotation.col(2).cross(Vec3(0.3, 0.5, 0.8)) + Vec3(0.1, 0.2, 0.3);
  const double size = pair.b.is_bounded() ? pair.b.size() : pair.a.size();
  if (between.norm() > 0) pair.pose_b.translation += 0.02 * size * step / between.norm() * between;
  const Vec3 turn = 0.01 * step / axis.norm() * axis;
  pair.pose_b.rotation = Quat(1, turn.x(), turn.y(), turn.z()).normalized().toRotationMatrix() * pair.pose_b.rotation;
  return pair;
}

}  // namespace

Workload make_workload(reference::PairKind kind, reference::PairClass pair_class, std::size_t n) {
  Workload work{std::string(name(kind)), std::string(name(pair_class)), {}, {}, 0};
  fill(work, n, [&](std::size_t i) { return reference::make_pair(kind, pair_class, i); });
  return work;
}

Workload make_motion(reference::PairKind kind, std::size_t n) {
  Workload work{std::string(name(kind)), "motion", {}, {}, tracks_of(n)};
  fill(work, work.tracks * motion_steps, [&](std::size_t i) { return motion_pair(kind, work.tracks, i); });
  return work;
}

std::optional<reference::PosedPair> named_pair(std::string_view kind, std::string_view pair_class, std::size_t n,
                                               std::size_t index) {
  for (std::size_t k = 0; k < reference::pair_kinds; ++k) {
    const auto pair_kind = static_cast<reference::PairKind>(k);
    if (name(pair_kind) != kind) continue;
    if (pair_class == "motion") return motion_pair(pair_kind, tracks_of(n), index);
    for (const reference::PairClass c : reference::all_pair_classes)
      if (name(c) == pair_class) return reference::make_pair(pair_kind, c, index);
  }
  return std::nullopt;
}

}  // namespace tandem::bench
