#include "round_depth.h"

#include <limits>

namespace tandem {
namespace {

constexpr int max_vertices = 100;
constexpr int max_faces = 2 * max_vertices;  // a closed triangulation has 2 v - 4
constexpr int max_known = 24;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double epsilon = std::numeric_limits<double>::epsilon();

struct Face {
  int v[3];
  int next[3];  ///< the face across the edge v[i] -> v[i + 1]
  Vec3 normal;  ///< unit, outward
};

Vec3 reach(const RoundPair& pair, const Vec3& n) {
  const RoundBody &a = pair.body[0], &b = pair.body[1];
  return a.point(a.support_piece(n), n) + b.point(b.support_piece(n), n);
}

class Search {
 public:
  Search(const RoundPair& pair, const Support& start) : pair_(pair), rounding_(16 * epsilon * pair.scale) {
    best_ = start;
    known_[known_count_++] = start.n;
  }

  Depth run();

 private:
  void try_axes();
  void try_from(const Vec3& n);
  bool is_known(const Face& f, const Vec3& w) const;
  double foot_margin(const Face& f, double offset) const;
  bool begin();
  void new_face(int slot, int a, int b, int c);
  bool add(int face, const Vec3& w);

  const RoundPair& pair_;
  double rounding_;
  Support best_;
  Vec3 known_[max_known];
  int known_count_ = 0;
  Vec3 vertex_[max_vertices];
  int vertices_ = 0;
  Face face_[max_faces];
  double key_[max_faces];     ///< offset of the faces still to be looked at, else infinity
  double offset_[max_faces];  ///< infinity: a free slot or a sliver
  int faces_ = 0;
  int free_[max_faces];
  int free_count_ = 0;
};

void Search::try_from(const Vec3& n) {
  const Support s = walk(pair_, n, -infinity);
  if (known_count_ < max_known) known_[known_count_++] = s.n;
  if (s.h < best_.h) best_ = s;
}

/// The directions where minima like to sit: the axes of both and the common perpendicular.
void Search::try_axes() {
  Vec3 axes[8];
  int count = 0;
  for (const RoundBody& body : pair_.body) {
    if (body.kind() == ShapeKind::sphere || body.kind() == ShapeKind::convex || body.kind() == ShapeKind::triangle)
      continue;
    axes[count++] = body.axes().col(2);
    if (body.kind() != ShapeKind::box && body.kind() != ShapeKind::ellipsoid) continue;
    axes[count++] = body.axes().col(0);
    axes[count++] = body.axes().col(1);
  }
  const Vec3 across = pair_.body[0].axis().cross(pair_.body[1].axis());
  if (across.squaredNorm() > 1e-20) axes[count++] = across.normalized();
  double least = best_.h;
  Vec3 from = Vec3::Zero();
  for (int i = 0; i < count; ++i)
    for (const double side : {1.0, -1.0}) {
      const Vec3 n = side * axes[i];
      const double h = n.dot(reach(pair_, n));
      if (h < least - rounding_) least = h, from = n;
    }
  if (least < best_.h - rounding_) try_from(from);
}

void Search::new_face(int slot, int a, int b, int c) {
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

bool Search::begin() {
  vertex_[0] = best_.point[0] + best_.point[1];
  vertex_[1] = reach(pair_, -best_.n);
  const Vec3 line = vertex_[1] - vertex_[0];
  const auto farther = [&](const Vec3& axis) {
    const Vec3 p = reach(pair_, axis), q = reach(pair_, -axis);
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

/// Adds w, seen by `face`. False if the horizon is not one loop: rounding has the last word.
bool Search::add(int face, const Vec3& w) {
  if (vertices_ == max_vertices) return false;
  int seen[max_faces], seen_count = 0;
  bool is_seen[max_faces];
  std::fill(is_seen, is_seen + faces_, false);
  seen[seen_count++] = face;
  is_seen[face] = true;
  for (int k = 0; k < seen_count; ++k)
    for (const int other : face_[seen[k]].next) {
      if (is_seen[other]) continue;
      const Face& f = face_[other];
      if (f.normal.dot(w - vertex_[f.v[0]]) > -rounding_ && f.normal != Vec3::Zero()) {
        is_seen[other] = true;
        seen[seen_count++] = other;
      }
    }
  struct Edge {
    int from, to, outer;
  } horizon[max_faces];
  int edges = 0;
  for (int k = 0; k < seen_count; ++k) {
    const Face& f = face_[seen[k]];
    for (int i = 0; i < 3; ++i)
      if (!is_seen[f.next[i]]) horizon[edges++] = {f.v[i], f.v[(i + 1) % 3], f.next[i]};
  }
  if (edges < 3 || faces_ + edges - seen_count - free_count_ > max_faces) return false;
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
  if (horizon[edges - 1].to != horizon[0].from) return false;

  for (int k = 0; k < seen_count; ++k) {
    key_[seen[k]] = offset_[seen[k]] = infinity;
    free_[free_count_++] = seen[k];
  }
  const int added = vertices_++;
  vertex_[added] = w;
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
  return true;
}

/// How far within its triangle the origin's foot on the face lies; negative: outside.
double Search::foot_margin(const Face& f, double offset) const {
  const Vec3 foot = offset * f.normal;
  double least = infinity;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = vertex_[f.v[i]], &q = vertex_[f.v[(i + 1) % 3]];
    const Vec3 in = f.normal.cross(q - p);
    least = std::min(least, in.dot(foot - p) / in.norm());
  }
  return least;
}

/// Is there a minimum near the face towards which h falls? w supports it along the face's normal.
bool Search::is_known(const Face& f, const Vec3& w) const {
  for (int i = 0; i < known_count_; ++i) {
    const double c = known_[i].dot(f.normal);
    if (c > 0.998 && known_[i].dot(w) < c * f.normal.dot(w)) return true;
  }
  return false;
}

Depth Search::run() {
  try_axes();
  Depth r;
  r.gap = best_.h;
  const bool corners = pair_.body[0].kind() == ShapeKind::convex || pair_.body[1].kind() == ShapeKind::convex;
  const double narrow = corners ? 0.04 : 0.04;  // radians: a hole so small holds one minimum
  if (best_.h > 0 && begin()) {
    for (;;) {
      int nearest = 0;
      for (int i = 1; i < faces_; ++i)
        if (key_[i] < key_[nearest]) nearest = i;
      const double offset = key_[nearest];
      if (offset >= best_.h - rounding_) {
        r.gap = 0;
        break;
      }
      const Face& f = face_[nearest];
      const double margin = offset > 0 ? foot_margin(f, offset) : 0;
      if (margin < 0) {  // its neighbour there is nearer the origin
        key_[nearest] = infinity;
        continue;
      }
      const Vec3 w = reach(pair_, f.normal);
      const double h = f.normal.dot(w);
      if (h < best_.h - rounding_) {
        try_from(f.normal);
        if (best_.h < 0) break;
      }
      if (h - offset <= rounding_) {
        key_[nearest] = infinity;
        continue;
      }
      if (offset > 0 && best_.h - offset < narrow * margin) {
        if (!is_known(f, w)) try_from(f.normal);
        key_[nearest] = infinity;
        continue;
      }
      if (!add(nearest, w)) {
        r.gap = best_.h - offset;
        break;
      }
    }
  }
  if (best_.h <= 0) r.gap = 0;
  r.best = best_;
  return r;
}

}  // namespace

Depth least_depth(const RoundPair& pair, const Support& start) { return Search(pair, start).run(); }

}  // namespace tandem
