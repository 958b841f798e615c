// The point of a hull nearest to another, by a search over its features (Lin and Canny 1991).
#include "round/hull_projection.h"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr int most_hull_steps = 32;

class HullDescent {
 public:
  HullDescent(const Hull& hull, const Vec3& p, std::uint32_t from) : hull_(hull), p_(p) { nearest_.vertex = from; }

  NearestOnHull run() {
    At at = At::corner;
    for (int step = 0; step < most_hull_steps; ++step) {
      at = at == At::corner ? from_corner() : at == At::edge ? from_edge() : from_face();
      if (at == At::end) return nearest_;
    }
    nearest_.surface = Surface::none;
    nearest_.q = p_;
    return nearest_;
  }

 private:
  enum class At { corner, edge, face, end };

  At end(Surface surface, const Vec3& q) {
    nearest_.surface = surface;
    nearest_.q = q;
    return At::end;
  }

  /// Moves to the edge that comes nearest to p.
  At from_corner() {
    const Vec3 v = hull_.vertices[nearest_.vertex], d = p_ - v;
    const std::uint32_t end_of_ring = hull_.neighbour_first[nearest_.vertex + 1];
    double best = 0, best2 = 1;  // distance along the edge times its length, and that squared
    for (std::uint32_t i = hull_.neighbour_first[nearest_.vertex]; i < end_of_ring; ++i) {
      const Vec3 e = hull_.vertices[hull_.neighbours[i]] - v;
      const double along = e.dot(d), length2 = e.squaredNorm();
      if (along > 0 && along * along * best2 > best * best * length2) best = along, best2 = length2, neighbour_ = i;
    }
    if (best == 0) return end(Surface::corner, v);
    if (best >= best2) {
      nearest_.vertex = hull_.neighbours[neighbour_];
      return At::corner;
    }
    fraction_ = best / best2;
    return At::edge;
  }

  /// Moves to the face beside the edge over which p lies, if there is one.
  At from_edge() {
    nearest_.other = hull_.neighbours[neighbour_];
    const Vec3 v = hull_.vertices[nearest_.vertex], e = hull_.vertices[nearest_.other] - v, q = v + fraction_ * e,
               r = p_ - q;
    const std::uint32_t first = hull_.neighbour_first[nearest_.vertex];
    const std::uint32_t left = hull_.neighbour_face[neighbour_];
    const std::uint32_t before = neighbour_ > first ? neighbour_ : hull_.neighbour_first[nearest_.vertex + 1];
    const std::uint32_t right = hull_.neighbour_face[before - 1];
    const Vec3 across = e.cross(r);  // n x e . r = n . e x r
    nearest_.face = left;
    if (hull_.faces[left].normal.dot(across) > 0) return At::face;
    nearest_.face = right;
    if (hull_.faces[right].normal.dot(across) < 0) return At::face;
    return end(Surface::straight, q);
  }

  /// Moves to the edge beyond which p lies farthest, if there is one.
  At from_face() {
    const Hull::Face& f = hull_.faces[nearest_.face];
    const std::uint32_t* loop = hull_.loop.data() + f.first;
    double most = 0;
    std::uint32_t a = 0, b = 0;
    for (std::uint32_t k = 0, last = loop[f.count - 1]; k < f.count; last = loop[k++]) {
      const Vec3 v = hull_.vertices[last], e = hull_.vertices[loop[k]] - v;
      const double beyond = e.cross(f.normal).dot(p_ - v);
      if (beyond > 0 && beyond * beyond > most * e.squaredNorm())
        most = beyond * beyond / e.squaredNorm(), a = last, b = loop[k];
    }
    if (most == 0) {
      const double height = f.normal.dot(p_ - hull_.vertices[nearest_.vertex]);
      return height < 0 ? end(Surface::none, p_) : end(Surface::flat, p_ - height * f.normal);
    }
    const Vec3 v = hull_.vertices[a], e = hull_.vertices[b] - v;
    const double along = e.dot(p_ - v), length2 = e.squaredNorm();
    nearest_.vertex = along < length2 ? a : b;
    if (!(along > 0 && along < length2)) return At::corner;
    fraction_ = along / length2;
    neighbour_ = hull_.neighbour_first[a];
    while (hull_.neighbours[neighbour_] != b) ++neighbour_;
    return At::edge;
  }

  const Hull& hull_;
  const Vec3 p_;
  NearestOnHull nearest_;
  std::uint32_t neighbour_ = 0;  ///< of the edge, counted at nearest_.vertex
  double fraction_ = 0;          ///< position along it
};

}  // namespace

NearestOnHull nearest_on_hull(const Hull& hull, const Vec3& p, std::uint32_t from) {
  return HullDescent(hull, p, from).run();
}

bool on_face(const Hull& hull, std::uint32_t face, const Vec3& q, double inward) {
  const Hull::Face& f = hull.faces[face];
  const std::uint32_t* loop = hull.loop.data() + f.first;
  for (std::uint32_t k = 0, last = loop[f.count - 1]; k < f.count; last = loop[k++]) {
    const Vec3 v = hull.vertices[last], in = f.normal.cross(hull.vertices[loop[k]] - v);
    const double depth = in.dot(q - v);
    if (!(depth > 0 && depth * depth > inward * inward * in.squaredNorm())) return false;
  }
  return true;
}

Vec3 end_on_face(const Hull& hull, std::uint32_t face, const Vec3& from, const Vec3& to, double rounding) {
  const Hull::Face& f = hull.faces[face];
  const std::uint32_t* loop = hull.loop.data() + f.first;
  double fraction = 1;
  for (std::uint32_t k = 0, last = loop[f.count - 1]; k < f.count; last = loop[k++]) {
    const Vec3 v = hull.vertices[last], e = hull.vertices[loop[k]] - v, out = e.cross(f.normal);
    const double beyond = out.dot(to - v);
    if (!(beyond > 0 && beyond * beyond > rounding * rounding * e.squaredNorm())) continue;
    const double before = std::max(0.0, -out.dot(from - v));
    fraction = std::min(fraction, before / (before + beyond));
  }
  return fraction == 1 ? to : Vec3(from + fraction * (to - from));
}

}  // namespace tandem
