// Builds the table of faces through which rays from the interior of a hull leave.
#include "shapes/hull_rays.h"

#include <limits>
#include <numeric>

namespace tandem {
namespace {

/// Searches the face that a ray from the interior point goes through: in the polar polytope, whose vertices are the
/// faces' normals over their distances, it is the vertex farthest along the ray.
class FaceDescent {
 public:
  explicit FaceDescent(const Hull& hull) : first_(hull.faces.size() + 1), beside_(2 * hull.edges.size()) {
    for (const Hull::Face& f : hull.faces) polar_.push_back(f.normal / (f.offset - f.normal.dot(hull.inside)));
    for (const Hull::Edge& e : hull.edges)
      for (const std::uint32_t f : e.face) ++first_[f];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    for (const Hull::Edge& e : hull.edges)
      for (const std::size_t i : {0u, 1u}) beside_[--first_[e.face[i]]] = e.face[1 - i];
  }
  /// The face that the ray goes through.
  std::uint32_t towards(const Vec3& ray) {
    double most = polar_[at_].dot(ray);
    for (std::uint32_t from = first_[at_]; from < first_[at_ + 1];) {
      const std::uint32_t other = beside_[from++];
      const double along = polar_[other].dot(ray);
      if (along > most) most = along, at_ = other, from = first_[other];
    }
    return at_;
  }

 private:
  std::vector<Vec3> polar_;
  std::vector<std::uint32_t> first_, beside_;  ///< faces across the edges of face i: beside_[first_[i], first_[i + 1])
  std::uint32_t at_ = 0;
};

/// The triangle that the ray goes through, of the fan of the face about its first corner.
RayMap::Corners corners_hit(const Hull& hull, const Hull::Face& face, const Vec3& ray) {
  const std::uint32_t* const loop = &hull.loop[face.first];
  std::uint32_t k = 2;
  const Vec3 first = hull.vertices[loop[0]] - hull.inside;
  while (k + 1 < face.count && (hull.vertices[loop[k]] - hull.inside).cross(first).dot(ray) < 0) ++k;
  const auto number = [](std::uint32_t i) { return static_cast<std::uint16_t>(i); };
  return {number(loop[0]), number(loop[k - 1]), number(loop[k])};
}

}  // namespace

RayMap map_rays(const Hull& hull) {
  RayMap map;
  if (hull.vertices.size() > std::numeric_limits<std::uint16_t>::max()) return map;
  map.corners_.resize(RayMap::cells);
  FaceDescent descent(hull);
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0})
      for (std::size_t i = 0; i < RayMap::side; ++i)
        for (std::size_t j = 0; j < RayMap::side; ++j) {
          const auto middle = [](std::size_t at) { return (2 * static_cast<double>(at) + 1) / RayMap::side - 1; };
          Vec3 ray;
          ray[k] = sign, ray[(k + 1) % 3] = middle(i), ray[(k + 2) % 3] = middle(j);
          map.corners_[RayMap::cell({ray[0], ray[1], ray[2]})] =
              corners_hit(hull, hull.faces[descent.towards(ray)], ray);
        }
  return map;
}

}  // namespace tandem
