// Triangles of two meshes that touch, or are equally near to rounding, and the direction that separates them all.
#pragma once
#include <cstddef>
#include <memory_resource>
#include <span>
#include <vector>

#include "meshes/traversal/least_translation.h"
#include "meshes/traversal/triangle_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/work_meter.h"
#include "triangles/triangle_kernel.h"

namespace tandem {

/// Of one pair of triangles rounding may choose the direction: of two in one plane, or with parallel edges. Together
/// they have one, if any: along it each pair is as far apart as the meshes, to rounding, and no solid is pushed into
/// the other through a face that is part of the touch.
class TouchingFaces {
 public:
  /// In one frame.
  struct Faces {
    Corners a, b;
    Vec3 normal_a, normal_b;  ///< unit; zero without area or outside
  };

  /// `gap`: the distance of the meshes, 0 if they intersect. `slack`: the distance that counts as touching. Metres.
  TouchingFaces(const MeshModel& a, const MeshModel& b, double gap, double slack, WorkMeter& meter,
                std::pmr::memory_resource* memory)
      : a_(a),
        b_(b),
        gap_(gap),
        slack_(slack),
        meter_(meter),
        pairs_(memory),
        faces_(memory),
        leaving_normals_(memory) {}

  void reserve(std::size_t pairs) { pairs_.reserve(pairs), faces_.reserve(pairs); }
  void add(const TrianglePair& pair, const Corners& a, const Corners& b);

  /// Looks for the direction (unit, from A to B): `first`, if it is one (zero: none), else the mean of the triangles'
  /// normals, else one of these, else one across two edges. False if there is none.
  bool separate(const Vec3& first);

  /// The one found; whether there is one.
  bool separable() const { return separable_; }
  const Vec3& direction() const { return n_; }
  /// The mean direction of the triangles' normals, A's minus B's; unit.
  const Vec3& sides() const { return sides_; }

  std::size_t size() const { return faces_.size(); }
  const Faces& faces(std::size_t k) const { return faces_[k]; }
  const TrianglePair& pair(std::size_t k) const { return pairs_[k]; }

  /// How far A's triangle of a pair reaches beyond B's.
  static double overlap(const Corners& a, const Corners& b, const Vec3& n);
  double overlap(std::size_t k, const Vec3& n) const { return overlap(faces_[k].a, faces_[k].b, n); }
  /// The most of all pairs, at least 0.
  double deepest_along(const Vec3& n);

  /// Where no direction separates all, as in a corner: sets the shortest translation that leads `step` off each face
  /// that a corner, an edge or a face of the other mesh touches inside. `edges`: and off planes of faces that touch
  /// along an edge, where that contradicts none of the others; of two such faces either may be wrong. These planes;
  /// none if no face is touched inside, or there is no such translation.
  std::vector<Constraint> leave_faces(double step, bool edges, Vec3& shortest);

  /// The direction along which B leaves such a face, if one is `n` to rounding, else `n`.
  Vec3 normal_near(const Vec3& n);

  /// True if B leaves such a face along -n, to rounding, and none along n: a triangle beside that face may have n.
  bool leads_back(const Vec3& n);

 private:
  static constexpr std::size_t at_once = 16;  // triangles between two counts of work

  void search(const Vec3& first);
  void consider(const Vec3& n);
  bool blocks(const Faces& f, const Vec3& n);
  bool leave_out_folded();
  Vec3 off_face(const Corners& face, const Vec3& n, bool solid, const Corners& other, const Vec3& m,
                bool other_solid) const;
  Vec3 leaving_normal(const Faces& f) const;
  std::span<const Vec3> leaving_normals();

  const MeshModel &a_, &b_;
  const double gap_, slack_;
  WorkMeter& meter_;
  std::pmr::vector<TrianglePair> pairs_;
  std::pmr::vector<Faces> faces_;
  std::pmr::vector<Vec3> leaving_normals_;  // normals of faces touched inside, from A to B; each once
  bool leaving_known_ = false;
  Vec3 sides_ = Vec3::Zero();
  Vec3 n_ = Vec3::UnitZ();
  bool separable_ = false;
  bool by_side_ = false;      // a direction was blocked by nothing but the side of a face
  std::size_t blocking_ = 0;  // the face that blocked
};

}  // namespace tandem
