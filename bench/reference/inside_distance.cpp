// The depth of the origin in A - B in 113-bit arithmetic, by the expanding polytope algorithm.
#include <array>
#include <functional>
#include <queue>
#include <unordered_map>
#include <utility>

#include "minkowski.h"

namespace tandem::reference {
namespace {

struct Face {
  std::array<std::size_t, 3> v;     ///< counterclockwise from outside
  std::array<std::size_t, 3> next;  ///< across the edge v[i], v[i + 1]
  Vec normal;                       ///< unit, outward
  Real offset;
  bool alive = true;
};

struct Edge {
  std::size_t from, to;  ///< the edge as the removed face has it
  std::size_t beyond;    ///< the face across it, which stays
};

class Polytope {
 public:
  explicit Polytope(const Difference& difference)
      : difference_(difference), thin_(Real(1e-28) * difference.scale()), coplanar_(Real(1e-30) * difference.scale()) {}

  /// Finds four points that span a volume; false where the difference is flat, and sets `flat_normal`.
  bool span();
  Vec flat_normal{1, 0, 0};

  std::size_t vertices() const { return vertex_.size(); }
  /// The face nearest the origin.
  std::size_t nearest();
  const Face& face(std::size_t i) const { return faces_[i]; }
  const std::vector<Face>& faces() const { return faces_; }
  /// Adds a vertex; false where rounding leaves no valid horizon.
  bool add(std::size_t seen, const Vec& w);

 private:
  std::size_t new_face(std::size_t a, std::size_t b, std::size_t c);
  bool horizon(std::size_t seen, const Vec& w, Real visible_beyond, std::vector<std::size_t>& gone,
               std::vector<Edge>& loop) const;
  void link(std::size_t face, std::size_t from, std::size_t other);

  const Difference& difference_;
  Real thin_, coplanar_;
  std::vector<Vec> vertex_;
  std::vector<Face> faces_;
  using Entry = std::pair<Real, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

std::size_t Polytope::new_face(std::size_t a, std::size_t b, std::size_t c) {
  const Vec n = cross(vertex_[b] - vertex_[a], vertex_[c] - vertex_[a]);
  const Real length = norm(n);
  // A face without area bounds nothing: it is never the nearest.
  const Vec unit = length > 0 ? n / length : Vec{};
  faces_.push_back({{a, b, c}, {}, unit, length > 0 ? dot(unit, vertex_[a]) : 2 * difference_.scale()});
  queue_.push({faces_.back().offset, faces_.size() - 1});
  return faces_.size() - 1;
}

void Polytope::link(std::size_t face, std::size_t from, std::size_t other) {
  for (std::size_t i = 0; i < 3; ++i)
    if (faces_[face].v[i] == from) faces_[face].next[i] = other;
}

bool Polytope::span() {
  const auto farthest = [&](const std::vector<Vec>& directions, auto&& distance, Real& most) {
    Vec best;
    most = -1;
    for (const Vec& d : directions)
      for (const Real sign : {Real(1), Real(-1)}) {
        const Vec w = difference_.support(sign * d);
        const Real far = distance(w);
        if (far > most) most = far, best = w;
      }
    return best;
  };
  const std::vector<Vec> axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Real most;
  const Vec p = difference_.support(axes[0]);
  const Vec q = farthest(
      axes, [&](const Vec& w) { return norm(w - p); }, most);
  if (!(most > thin_)) return false;
  const Vec line = (q - p) / most;
  Vec across;
  for (const Vec& axis : axes) {
    const Vec c = cross(line, axis);
    if (norm(c) > norm(across)) across = c;
  }
  across = across / norm(across);
  flat_normal = across;
  const Vec r = farthest(
      {across, cross(line, across)}, [&](const Vec& w) { return norm(cross(line, w - p)); }, most);
  if (!(most > thin_)) return false;
  Vec up = cross(q - p, r - p);
  up = up / norm(up);
  flat_normal = up;
  const Vec s = farthest(
      {up}, [&](const Vec& w) { return abs(dot(up, w - p)); }, most);
  if (!(most > thin_)) return false;
  vertex_ = {p, q, r, s};
  if (dot(up, s - p) > 0) std::swap(vertex_[1], vertex_[2]);
  // Now vertex 3 lies below the triangle 0 1 2.
  new_face(0, 1, 2), new_face(0, 2, 3), new_face(0, 3, 1), new_face(1, 3, 2);
  faces_[0].next = {2, 3, 1};
  faces_[1].next = {0, 3, 2};
  faces_[2].next = {1, 3, 0};
  faces_[3].next = {2, 1, 0};
  return true;
}

std::size_t Polytope::nearest() {
  while (!faces_[queue_.top().second].alive) queue_.pop();
  return queue_.top().second;
}

bool Polytope::horizon(std::size_t seen, const Vec& w, Real visible_beyond, std::vector<std::size_t>& gone,
                       std::vector<Edge>& loop) const {
  gone = {seen};
  loop.clear();
  std::unordered_map<std::size_t, bool> visible{{seen, true}};
  for (std::size_t i = 0; i < gone.size(); ++i) {
    const Face& f = faces_[gone[i]];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, is_new] = visible.try_emplace(f.next[k], false);
      const Face& g = faces_[f.next[k]];
      if (is_new && dot(g.normal, w) - g.offset > visible_beyond) {
        at->second = true;
        gone.push_back(f.next[k]);
      }
      if (!at->second) loop.push_back({f.v[k], f.v[(k + 1) % 3], f.next[k]});
    }
  }
  // The horizon must be one closed loop, each vertex once.
  std::unordered_map<std::size_t, std::size_t> by_start;
  for (std::size_t i = 0; i < loop.size(); ++i)
    if (!by_start.emplace(loop[i].from, i).second) return false;
  if (loop.size() < 3) return false;
  std::vector<Edge> ordered = {loop[0]};
  while (ordered.size() < loop.size()) {
    const auto at = by_start.find(ordered.back().to);
    if (at == by_start.end() || at->second == 0) return false;
    ordered.push_back(loop[at->second]);
  }
  if (ordered.back().to != ordered.front().from) return false;
  loop = std::move(ordered);
  return true;
}

bool Polytope::add(std::size_t seen, const Vec& w) {
  std::vector<std::size_t> gone;
  std::vector<Edge> loop;
  // Faces in whose plane w lies are removed as well, so that the new faces on their edges are not slivers.
  if (!horizon(seen, w, -coplanar_, gone, loop) && !horizon(seen, w, coplanar_, gone, loop)) return false;
  vertex_.push_back(w);
  const std::size_t apex = vertex_.size() - 1, first = faces_.size();
  for (const std::size_t g : gone) faces_[g].alive = false;
  const std::size_t n = loop.size();
  for (const Edge& e : loop) new_face(e.from, e.to, apex);
  for (std::size_t i = 0; i < n; ++i) {
    Face& f = faces_[first + i];
    f.next = {loop[i].beyond, first + (i + 1) % n, first + (i + n - 1) % n};
    link(loop[i].beyond, loop[i].to, first + i);
  }
  return true;
}

}  // namespace

Interval inside_distance(const Difference& difference, Real tolerance, std::size_t most_vertices) {
  const Real scale = difference.scale();
  Interval r;
  Polytope polytope(difference);
  if (!polytope.span()) {
    // A flat difference: the origin lies in it, hence on its surface.
    r.normal = polytope.flat_normal;
    r.lower = -(Real(4e-28) * scale);
    r.upper = Real(4e-28) * scale;
    r.unique = false;
    return r;
  }
  r.lower = -2 * scale;
  r.upper = scale;
  for (;;) {
    const std::size_t nearest = polytope.nearest();
    const Face& face = polytope.face(nearest);
    const Vec w = difference.support(face.normal);
    const Real depth = dot(face.normal, w);
    if (-depth > r.lower) {
      r.lower = -depth;
      r.normal = face.normal;
    }
    r.upper = -face.offset;
    if (!(r.upper - r.lower > tolerance)) break;
    if (polytope.vertices() >= most_vertices) break;
    if (!polytope.add(nearest, w)) break;
  }
  const Real close = -r.lower + Real(1e-9) * scale;
  for (const Face& f : polytope.faces())
    if (f.alive && f.offset <= close && norm(f.normal - r.normal) > Real(1e-3)) r.unique = false;
  return r;
}

}  // namespace tandem::reference
