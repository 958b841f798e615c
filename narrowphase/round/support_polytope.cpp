// The expanding polytope within A - B, for round bodies.
#include "round/support_polytope.h"

#include <utility>

namespace tandem {

void SupportPolytope::new_face(int slot, int a, int b, int c) {
  Face& f = face_[slot];
  f.v[0] = a, f.v[1] = b, f.v[2] = c;
  const Vec3 &p = vertex_[a], &q = vertex_[b], &r = vertex_[c];
  const Vec3 pq = q - p, qr = r - q, rp = p - r;
  const double pq2 = pq.squaredNorm(), qr2 = qr.squaredNorm(), rp2 = rp.squaredNorm();
  const double longest = std::max({pq2, qr2, rp2});
  const Vec3 n = longest == qr2 ? Vec3(rp.cross(pq)) : longest == rp2 ? Vec3(pq.cross(qr)) : Vec3(qr.cross(rp));
  const double length = n.norm();
  if (length > rounding_ * std::sqrt(longest)) {
    f.normal = n / length;
    offset_[slot] = f.normal.dot(p);
  } else {
    f.normal.setZero();
    offset_[slot] = infinity;
  }
  key_[slot] = offset_[slot];
}

bool SupportPolytope::begin(const Support& start) {
  vertex_[0] = start.point[0] + start.point[1];
  vertex_[1] = pair_.support(-start.n);
  const Vec3 line = vertex_[1] - vertex_[0];
  const auto farther = [&](const Vec3& axis) {
    const Vec3 p = pair_.support(axis), q = pair_.support(-axis);
    return axis.dot(p - vertex_[0]) >= axis.dot(vertex_[0] - q) ? p : q;
  };
  vertex_[2] = farther(any_perpendicular(line));
  const Vec3 across = line.cross(vertex_[2] - vertex_[0]);
  if (!(across.norm() > rounding_ * line.norm())) return false;
  vertex_[3] = farther(across.normalized());
  const double side = across.dot(vertex_[3] - vertex_[0]);
  if (!(std::abs(side) > rounding_ * across.norm())) return false;
  if (side > 0) std::swap(vertex_[1], vertex_[2]);
  vertices_ = faces_ = 4;
  new_face(0, 0, 1, 2);
  new_face(1, 0, 3, 1);
  new_face(2, 1, 3, 2);
  new_face(3, 2, 3, 0);
  constexpr int next[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  for (int i = 0; i < 4; ++i) std::copy(next[i], next[i] + 3, face_[i].next);
  return true;
}

/// Marks and lists the faces that see w, starting with one; returns how many.
int SupportPolytope::find_seen(int face, const Vec3& w, int* seen, bool* is_seen) const {
  int count = 0;
  std::fill(is_seen, is_seen + faces_, false);
  seen[count++] = face;
  is_seen[face] = true;
  for (int k = 0; k < count; ++k)
    for (const int other : face_[seen[k]].next) {
      if (is_seen[other]) continue;
      const Face& f = face_[other];
      if (f.normal.dot(w - vertex_[f.v[0]]) > -rounding_ && f.normal != Vec3::Zero()) {
        is_seen[other] = true;
        seen[count++] = other;
      }
    }
  return count;
}

/// Sorts the edges into a loop. False if they are not a single loop.
bool SupportPolytope::make_loop(HorizonEdge* horizon, int edges) {
  for (int k = 0; k + 1 < edges; ++k) {
    int found = -1;
    for (int j = k + 1; j < edges; ++j)
      if (horizon[j].from == horizon[k].to) {
        if (found >= 0) return false;
        found = j;
      }
    if (found < 0) return false;
    std::swap(horizon[k + 1], horizon[found]);
  }
  return horizon[edges - 1].to == horizon[0].from;
}

/// Makes a face from each edge of the horizon to the new vertex.
void SupportPolytope::close_horizon(const HorizonEdge* horizon, int edges, int added) {
  int first = -1, last = -1;
  for (int k = 0; k < edges; ++k) {
    const auto [from, to, outer] = horizon[k];
    const int i = free_count_ > 0 ? free_[--free_count_] : faces_++;
    new_face(i, from, to, added);
    face_[i].next[0] = outer;
    for (int j = 0; j < 3; ++j)
      if (face_[outer].v[j] == to && face_[outer].v[(j + 1) % 3] == from) face_[outer].next[j] = i;
    if (last >= 0) {
      face_[last].next[1] = i;
      face_[i].next[2] = last;
    } else {
      first = i;
    }
    last = i;
  }
  face_[last].next[1] = first;
  face_[first].next[2] = last;
}

bool SupportPolytope::add(int face, const Vec3& w) {
  if (vertices_ == max_vertices) return false;
  int seen[max_faces];
  bool is_seen[max_faces];
  const int seen_count = find_seen(face, w, seen, is_seen);
  HorizonEdge horizon[max_faces];
  int edges = 0;
  for (int k = 0; k < seen_count; ++k) {
    const Face& f = face_[seen[k]];
    for (int i = 0; i < 3; ++i)
      if (!is_seen[f.next[i]]) horizon[edges++] = {f.v[i], f.v[(i + 1) % 3], f.next[i]};
  }
  if (edges < 3 || faces_ + edges - seen_count - free_count_ > max_faces) return false;
  if (!make_loop(horizon, edges)) return false;
  for (int k = 0; k < seen_count; ++k) {
    key_[seen[k]] = offset_[seen[k]] = infinity;
    free_[free_count_++] = seen[k];
  }
  const int added = vertices_++;
  vertex_[added] = w;
  close_horizon(horizon, edges, added);
  return true;
}

double SupportPolytope::foot_margin(int face) const {
  const Face& f = face_[face];
  const Vec3 foot = key_[face] * f.normal;
  double least = infinity;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = vertex_[f.v[i]], &q = vertex_[f.v[(i + 1) % 3]];
    const Vec3 in = f.normal.cross(q - p);
    const double margin = in.dot(foot - p) / in.norm();
    // Of the two faces at an edge that the origin is on, neither may be left for the other.
    const bool nearer = offset_[f.next[i]] < offset_[face];
    least = std::min(least, nearer ? margin : std::max(margin, 0.0));
  }
  return least;
}

}  // namespace tandem
