// The direction that separates touching triangles of two meshes.
#include "meshes/traversal/touching_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "manifold/patch_point.h"
#include "meshes/traversal/folded_triangles.h"
#include "shapes/shape_insides.h"
#include "tolerances.h"

namespace tandem {
namespace {

// Pairs of touching triangles whose edge cross products are tried as directions.
constexpr std::size_t crossed_faces = 16;
// Normals of faces that are touched inside. Curved faces in each other have more, and seldom a translation off them
// all.
constexpr std::size_t most_normals = 64;

double most_of(const Vec3& n, std::span<const Vec3> points) {
  double most = -infinity;
  for (const Vec3& p : points) most = std::max(most, n.dot(p));
  return most;
}

// Of a triangle and the points of another one in its plane, with this normal: do they overlap by more than `slack`
// along the normals of all sides?
bool overlap_in_plane(const Corners& face, std::span<const Vec3> points, const Vec3& n, double slack) {
  const auto across = [&](const Vec3& side) { return n.cross(side).stableNormalized(); };
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 inward = across(face[(i + 1) % 3] - face[i]);
    if (!(most_of(inward, points) - inward.dot(face[i]) > slack)) return false;
  }
  for (std::size_t i = 0; points.size() > 1 && i < points.size(); ++i) {
    const Vec3 to_side = across(points[(i + 1) % points.size()] - points[i]);
    // Of an edge both sides are the outer one.
    for (const Vec3& inward : {to_side, Vec3(-to_side)}) {
      const bool outer = points.size() == 3 && inward.dot(points[(i + 2) % 3] - points[i]) < 0;
      if (!outer && !(most_along(inward, face) - inward.dot(points[i]) > slack)) return false;
    }
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

// The normal along which the other triangle leaves the inside of a face, which it touches with a corner, an edge or
// over an area; else zero.
Vec3 TouchingFaces::off_face(const Corners& face, const Vec3& n, bool solid, const Corners& other, const Vec3& m,
                             bool other_solid) const {
  const double near = gap_ + slack_;
  std::array<Vec3, 3> on;
  std::size_t count = 0;
  double above = 0, below = 0;
  for (const Vec3& v : other) {
    const double height = n.dot(v - face[0]);
    if (std::abs(height) <= near)
      on[count++] = v;
    else
      (height > 0 ? above : below) += height;
  }
  const bool crosses = above > 0 && below < 0;
  if (n.isZero(0) || count == 0 || crosses || !overlap_in_plane(face, std::span(on).first(count), n, slack_))
    return Vec3::Zero();
  // The orientation of a surface without an inside means nothing.
  const bool behind = count < 3 ? below < 0 : n.dot(m) > 0;
  if (!behind) return n;
  return solid || (count == 3 && !other_solid) ? Vec3(Vec3::Zero()) : Vec3(-n);
}

Vec3 TouchingFaces::leaving_normal(const Faces& f) const {
  const Vec3 n = off_face(f.a, f.normal_a, a_.solid, f.b, f.normal_b, b_.solid);
  return n.isZero(0) ? Vec3(-off_face(f.b, f.normal_b, b_.solid, f.a, f.normal_a, a_.solid)) : n;
}

std::span<const Vec3> TouchingFaces::leaving_normals() {
  if (leaving_known_) return leaving_normals_;
  leaving_known_ = true;
  leave_out_folded();
  for (const Faces& f : faces_) {
    meter_.spend(2);
    const Vec3 n = leaving_normal(f);
    const auto is_n = [&](const Vec3& known) { return known.dot(n) > tolerance::flush_face; };
    if (n.norm() > 0.5 && std::none_of(leaving_normals_.begin(), leaving_normals_.end(), is_n))
      leaving_normals_.push_back(n);
    if (leaving_normals_.size() > most_normals) {
      leaving_normals_.clear();
      break;
    }
  }
  return leaving_normals_;
}

std::vector<Constraint> TouchingFaces::leave_faces(double step, bool edges, Vec3& shortest) {
  constexpr double precision = 1.0 / 8, longest = 8;  // over a step
  std::vector<Constraint> beyond;
  for (const Vec3& n : leaving_normals()) beyond.push_back({n, step});
  if (!shortest_feasible(beyond, precision * step, shortest)) return {};
  for (std::size_t k = 0; edges && k < faces_.size() && !beyond.empty() && beyond.size() < most_normals; ++k) {
    meter_.spend();
    const Vec3 &n = faces_[k].normal_a, &m = faces_[k].normal_b;
    const auto is_n = [&](const Constraint& known) { return known.normal.dot(n) > tolerance::flush_face; };
    if (!(n.dot(m) < -tolerance::flush_face) || std::any_of(beyond.begin(), beyond.end(), is_n)) continue;
    beyond.push_back({n, step});
    if (Vec3 at; shortest_feasible(beyond, precision * step, at) && at.norm() <= longest * step)
      shortest = at;
    else
      beyond.pop_back();
  }
  return beyond;
}

Vec3 TouchingFaces::normal_near(const Vec3& n) {
  Vec3 nearest = n;
  double most = tolerance::flush_face;
  for (const Vec3& flush : leaving_normals())
    if (const double cosine = flush.dot(n); cosine > most) most = cosine, nearest = flush;
  return nearest;
}

bool TouchingFaces::leads_back(const Vec3& n) {
  const auto leaves_along = [&](const Vec3& d) {
    return std::any_of(leaving_normals().begin(), leaving_normals().end(),
                       [&](const Vec3& leaving) { return leaving.dot(d) > tolerance::flush_face; });
  };
  return leaves_along(-n) && !leaves_along(n);
}

}  // namespace tandem
