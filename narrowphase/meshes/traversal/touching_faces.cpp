// The direction that separates touching triangles of two meshes.
#include "meshes/traversal/touching_faces.h"

#include <algorithm>

#include "manifold/patch_point.h"
#include "meshes/traversal/folded_triangles.h"
#include "shapes/shape_insides.h"

namespace tandem {
namespace {

// Pairs of touching triangles whose edge cross products are tried as directions.
constexpr std::size_t crossed_faces = 16;

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

// Their normals do not count. False if there are none.
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

}  // namespace tandem
