// The search for a translation of the length of a rounding error that separates two touching meshes.
#include "meshes/depth/touching_meshes.h"

#include <algorithm>
#include <memory_resource>
#include <optional>
#include <vector>

#include "meshes/traversal/least_translation.h"
#include "meshes/traversal/mesh_nearest.h"
#include "meshes/traversal/touching_faces.h"
#include "pairs/convex_pair.h"
#include "shapes/lent_memory.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "shapes/triangle_height.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int rounds = 8;
constexpr int work_of_triangles = 16;        // of a distance of two triangles
constexpr double steps_of_coordinates = 16;  // in a step: triangles there are as deep as several
constexpr double longest = 8;                // translations, over a step
constexpr double apart_already = 1.0 / 8;    // over a step: triangles that it has not sunk into each other

// World axes, A's translation zero.
class TouchingMeshes {
 public:
  TouchingMeshes(const Posed& a, const Posed& b, double slack, const NarrowPhaseOptions& options)
      : a_(a),
        b_(b),
        step_(step_of(b, slack)),
        options_(options),
        meter_(options.limit),
        touching_(mesh_of(a.shape), mesh_of(b.shape), 0, step_, meter_, lent_memory(options)) {}

  // Does no pair overlap, of many some? A translation is tried in any case: this saves most of those in vain.
  bool seem_to_touch(std::span<const TrianglePair> pairs, double certain) {
    constexpr std::size_t most = 256;
    const double deepest = 2 * step_;
    if (certain > deepest) return false;
    for (std::size_t k = 0; k < pairs.size(); k += 1 + pairs.size() / most)
      if (overlap(pairs[k], Vec3::Zero()).signed_distance < -deepest) return false;
    return true;
  }

  // Takes pairs that intersect, and those between which rounding leaves a gap.
  void add_touching(std::span<const TrianglePair> pairs) {
    for (const TrianglePair& pair : pairs.first(std::min(pairs.size(), most_touching))) add_touching(pair);
    const auto meet = [&](std::uint32_t i, std::uint32_t j) {
      return std::binary_search(pairs.begin(), pairs.end(), TrianglePair{i, j});
    };
    const auto visit = [&](const TrianglePair& pair, const Nearest& near) {
      if (near.distance > 0) add_touching(pair);
      return touching_.size() < 2 * most_touching;
    };
    NearestSearch(a_, b_, options_.limit).each_within(step_, meet, visit, {});
  }

  // Along the direction that separates all that touches, else off the faces that are touched inside, else along the
  // mean of the normals.
  std::optional<Vec3> separate() {
    if (touching_.separate(Vec3::Zero()))
      if (const auto by = free_beyond(step_ * touching_.direction())) return by;
    for (const bool edges : {true, false}) {
      Vec3 at;
      planes_ = touching_.leave_faces(step_, edges, at);
      if (planes_.empty() || at.norm() > longest * step_) continue;
      if (const auto by = free_beyond(at)) return by;
    }
    planes_.clear();
    if (touching_.sides().norm() < 0.5) return std::nullopt;
    return free_beyond(step_ * touching_.sides());
  }

 private:
  bool is_free(const Vec3& by) const {
    return !meshes_collide(a_, {b_.shape, moved(by)}, options_.limit) &&
           !meshes_collide(a_, {b_.shape, moved(2 * by)}, options_.limit);
  }

  // Where B is moved by `at`, pairs still meet: a translation has to lead beyond the plane between these. False where
  // all such planes are known.
  bool add_planes(const Vec3& at) {
    constexpr std::size_t most = 64;
    PairMemory memory(std::pmr::get_default_resource());
    const Pose pose = moved(at);
    TriangleTest test(a_.pose, pose, reach(mesh_of(b_.shape)));
    const TrianglePairs pairs = meeting_pairs(a_, {b_.shape, pose}, test, options_, memory, nullptr);
    return add_planes(std::span(pairs).first(std::min(most, pairs.size())), at);
  }

  bool add_planes(std::span<const TrianglePair> pairs, const Vec3& at) {
    const std::size_t before = planes_.size();
    for (const bool sunk : {true, false}) {
      for (const TrianglePair& pair : pairs) {
        const PairAnswer r = overlap(pair, at);
        if ((r.signed_distance < -apart_already * step_) != sunk) continue;
        const Vec3 n = normal(a_, pair[0]), m = normal(b_, pair[1]);
        // Of faces that slide on each other rounding tells the way out.
        if (sunk)
          add(r.normal);
        else if (n.dot(m) < -tolerance::flush_face)
          add(n);
      }
      if (planes_.size() > before) return true;
    }
    return false;
  }

  // Beyond them all; false where there is no such translation, or only longer ones than a touch has.
  bool shortest(Vec3& at) const {
    return shortest_feasible(planes_, apart_already * step_, at) && at.norm() <= longest * step_;
  }

  // A translation that is free, from `at` on by the planes between what still meets there.
  std::optional<Vec3> free_beyond(Vec3 at) {
    for (int i = 0; i < rounds; ++i) {
      if (is_free(at)) return at;
      if (!add_planes(at) || !shortest(at)) break;
    }
    return std::nullopt;
  }

  // Far out, what is no longer than the distance of two coordinates there would move nothing.
  static double step_of(const Posed& b, double slack) {
    return std::max(slack / 2, steps_of_coordinates * epsilon * b.pose.translation.cwiseAbs().maxCoeff());
  }

  Pose moved(const Vec3& by) const { return {b_.pose.rotation, b_.pose.translation + by}; }

  PairAnswer overlap(const TrianglePair& pair, const Vec3& at) {
    meter_.spend(work_of_triangles);
    const Corners p = mesh_of(a_.shape).corners(pair[0]), q = mesh_of(b_.shape).corners(pair[1]);
    return solve_convex(TriangleView(p), a_.pose, TriangleView(q), moved(at), Request::distance, {}, nullptr);
  }

  void add_touching(const TrianglePair& pair) {
    meter_.spend();
    Corners p = mesh_of(a_.shape).corners(pair[0]), q = mesh_of(b_.shape).corners(pair[1]);
    for (Vec3& v : p) v = a_.pose.rotation * v;
    for (Vec3& v : q) v = moved(Vec3::Zero()) * v;
    touching_.add(pair, p, q);
  }

  // Unit, in the world; zero without area.
  static Vec3 normal(const Posed& mesh, std::uint32_t t) {
    return mesh.pose.rotation * area_vector(mesh_of(mesh.shape).corners(t)).stableNormalized();
  }

  // Unless it contradicts the others: where two edges touch, each of two faces may lead off.
  void add(const Vec3& n) {
    const auto is_known = [&](const Constraint& plane) { return plane.normal.dot(n) > tolerance::flush_face; };
    if (n.norm() < 0.5 || std::any_of(planes_.begin(), planes_.end(), is_known)) return;
    planes_.push_back({n, step_});
    if (Vec3 at; !shortest(at)) planes_.pop_back();
  }

  const Posed &a_, &b_;
  const double step_;  // of a translation beyond each plane
  const NarrowPhaseOptions& options_;
  WorkMeter meter_;
  TouchingFaces touching_;
  std::vector<Constraint> planes_;
};

}  // namespace

std::optional<Vec3> separating_translation(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                                           double certain, double slack, const NarrowPhaseOptions& options) {
  TouchingMeshes meshes(a, b, slack, options);
  if (!meshes.seem_to_touch(pairs, certain)) return std::nullopt;
  meshes.add_touching(pairs);
  return meshes.separate();
}

}  // namespace tandem
