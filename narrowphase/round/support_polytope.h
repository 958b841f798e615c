// A polytope within A - B that grows by points of its surface (van den Bergen 2001).
#pragma once
#include "round/support_descent.h"

namespace tandem {

/// The hull of points of A - B, at most some 480, and which of its faces are still to be examined.
class SupportPolytope {
 public:
  struct Face {
    int v[3];
    int next[3];  ///< the face across the edge v[i] -> v[i + 1]
    Vec3 normal;  ///< unit, outward
  };

  /// `rounding`: metres; points no farther beyond a face count as on it.
  SupportPolytope(const RoundPair& pair, double rounding) : pair_(pair), rounding_(rounding) {}

  /// Makes a tetrahedron with the support's point as a vertex. False if A - B is flat there, to rounding.
  bool begin(const Support& start);
  /// The face nearest the origin of those still to be examined.
  int nearest() const {
    int nearest = 0;
    for (int i = 1; i < faces_; ++i)
      if (key_[i] < key_[nearest]) nearest = i;
    return nearest;
  }
  const Face& face(int i) const { return face_[i]; }
  /// The distance of a face's plane from the origin, if the face is still to be examined; else infinity.
  double offset(int i) const { return key_[i]; }
  void leave(int i) { key_[i] = infinity; }
  /// The distance of the origin's projection on the face from the triangle's border, if inside; negative only beyond an
  /// edge whose other face is nearer the origin.
  double foot_margin(int face) const;
  /// Adds w, seen by `face`. False if there is no room, or rounding makes the horizon more than one loop.
  bool add(int face, const Vec3& w);

 private:
  static constexpr int max_vertices = 480;
  static constexpr int max_faces = 2 * max_vertices;  // a closed triangulation has 2 v - 4
  /// An edge between a face that sees the new point and one that does not.
  struct HorizonEdge {
    int from, to, outer;
  };

  void new_face(int slot, int a, int b, int c);
  int find_seen(int face, const Vec3& w, int* seen, bool* is_seen) const;
  static bool make_loop(HorizonEdge* horizon, int edges);
  void close_horizon(const HorizonEdge* horizon, int edges, int added);

  const RoundPair& pair_;
  double rounding_;
  Vec3 vertex_[max_vertices];
  int vertices_ = 0;
  Face face_[max_faces];
  double key_[max_faces];     ///< offset of the faces still to be examined, else infinity
  double offset_[max_faces];  ///< infinity: a free slot or a sliver
  int faces_ = 0;
  int free_[max_faces];
  int free_count_ = 0;
};

}  // namespace tandem
