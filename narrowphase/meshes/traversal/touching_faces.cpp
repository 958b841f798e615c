// The direction that separates touching triangles of two meshes.
#include "meshes/traversal/touching_faces.h"

#include <algorithm>
#include <utility>

#include "manifold/patch_point.h"
#include "meshes/traversal/folded_triangles.h"
#include "shapes/shape_insides.h"
#include "tolerances.h"

namespace tandem {
namespace {

// Pairs of touching triangles whose edge cross products are tried as directions.
constexpr std::size_t crossed_faces = 16;

// Of two triangles in one plane with this normal: do they overlap by more than `slack` along each side's normal?
bool overlap_in_plane(const Corners& p, const Corners& q, const Vec3& n, double slack) {
  for (const auto& [own, other] : {std::pair{&p, &q}, std::pair{&q, &p}})
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 side = (*own)[(i + 1) % 3] - (*own)[i], across = n.cross(side).stableNormalized();
      const Vec3 inward = across.dot((*own)[(i + 2) % 3] - (*own)[i]) < 0 ? Vec3(-across) : across;
      if (!(most_along(inward, *other) - inward.dot((*own)[i]) > slack)) return false;
    }
  return true;
}

}  // namespace

void TouchingFaces::add(const TrianglePair& pair, const Corners& a, const Corners& b) {
  pairs_.push_back(pair);
  faces_.push_back({a, b, area_vector(a).stableNormalized(), area_vector(b).stableNormalized()});
}

bool TouchingFaces::separate(const Vec3& first) {
  search(first);
  if (by_side_ && leave_out_folded()) search(first);
  return separable_;
}

double TouchingFaces::overlap(const Corners& a, const Corners& b, const Vec3& n) {
  return most_along(n, a) - least_along(n, b);
}

double TouchingFaces::deepest_along(const Vec3& n) {
  double most = 0;
  for (std::size_t k = 0; k < faces_.size(); ++k) {
    if (k % at_once == 0) meter_.spend(2);
    most = std::max(most, overlap(k, n));
  }
  return most;
}

void TouchingFaces::search(const Vec3& first) {
  separable_ = false;
  sides_.setZero();
  if (faces_.empty()) return;
  consider(first);
  for (std::size_t k = 0; k < faces_.size(); ++k) {
    if (k % at_once == 0) meter_.spend();
    sides_ += faces_[k].normal_a - faces_[k].normal_b;
  }
  sides_ = sides_.stableNormalized();
  consider(sides_);
  for (std::size_t k = 0; k < faces_.size() && !separable_; ++k) {
    consider(faces_[k].normal_a);
    consider(-faces_[k].normal_b);
  }
  for (std::size_t k = 0; k < std::min(faces_.size(), crossed_faces) && !separable_; ++k)
    for (std::size_t edges = 0; edges < 9; ++edges) {
      const auto edge = [](const Corners& t, std::size_t e) { return t[(e + 1) % 3] - t[e]; };
      const Vec3 n = edge(faces_[k].a, edges / 3).cross(edge(faces_[k].b, edges % 3)).stableNormalized();
      consider(n), consider(-n);
    }
}

// Takes the direction if it separates them and none did before. The face that blocked the one before is tried first:
// with many triangles hardly any direction is tested against more than a few.
void TouchingFaces::consider(const Vec3& n) {
  if (separable_ || n.norm() < 0.5 || blocks(faces_[blocking_], n)) return;
  for (std::size_t k = 0; k < faces_.size(); ++k) {
    if (k % at_once == 0) meter_.spend(2);
    if (blocks(faces_[k], n)) {
      blocking_ = k;
      return;
    }
  }
  n_ = n;
  separable_ = true;
}

bool TouchingFaces::blocks(const Faces& f, const Vec3& n) {
  // A solid must not be pushed into.
  const bool into_a = a_.solid && n.dot(f.normal_a) < -carries_patch,
             into_b = b_.solid && n.dot(f.normal_b) > carries_patch;
  const bool overlaps = overlap(f.a, f.b, n) + gap_ > slack_;
  if (into_a || into_b) by_side_ = by_side_ || !overlaps;
  return into_a || into_b || overlaps;
}

bool TouchingFaces::leave_out_folded() {
  std::pmr::memory_resource* const memory = faces_.get_allocator().resource();
  const FoldedTriangles of_a(a_, pairs_, 0, meter_, memory), of_b(b_, pairs_, 1, meter_, memory);
  if (of_a.empty() && of_b.empty()) return false;
  for (std::size_t k = 0; k < faces_.size(); ++k) {
    if (of_a.contain(pairs_[k][0])) faces_[k].normal_a.setZero();
    if (of_b.contain(pairs_[k][1])) faces_[k].normal_b.setZero();
  }
  return true;
}

Vec3 TouchingFaces::way_off(std::size_t k) const {
  const Faces& f = faces_[k];
  const double cosine = f.normal_a.dot(f.normal_b);
  // The orientation of a surface without an inside means nothing.
  const bool flush = cosine < -tolerance::flush_face || (a_.solid != b_.solid && cosine > tolerance::flush_face);
  if (!flush || !overlap_in_plane(f.a, f.b, f.normal_a, slack_)) return Vec3::Zero();
  return b_.solid && !a_.solid ? Vec3(-f.normal_b) : f.normal_a;
}

}  // namespace tandem
