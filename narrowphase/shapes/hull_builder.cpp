// Builds convex hulls by Qhull (Barber, Dobkin and Huhdanpaa, 1996).
#include "shapes/hull_builder.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <deque>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "shapes/hull_rays.h"
#include "shapes/metered_sort.h"
#include "shapes/support_kernel.h"
#include "shapes/triangle_height.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace tandem {
namespace {

using Loops = std::vector<std::vector<std::uint32_t>>;  // of indices of input points

// A frame of the points: an origin among them, and orthonormal right-handed axes along their extents, longest first.
struct Frame {
  std::uint32_t origin;
  Mat3 axes;  // axes as rows
  // Largest distances from the origin, from the first axis, from the plane of the first two.
  Vec3 extent = Vec3::Zero();
};

// The cost of a pass over so many points, in units of the meter.
int pass_over(std::size_t points) { return 1 + static_cast<int>(std::min<std::size_t>(points / 16, 1 << 20)); }

Vec3 any_normal(const Vec3& v) {
  int k;
  v.cwiseAbs().minCoeff(&k);
  return v.cross(Vec3::Unit(k)).normalized();
}

Frame find_frame(std::span<const Vec3> p, WorkMeter& meter) {
  Frame f;
  f.origin = 0;
  f.axes.setIdentity();
  for (std::uint32_t i = 1; i < p.size(); ++i)
    if (p[i].x() < p[f.origin].x()) f.origin = i;
  const Vec3 o = p[f.origin];

  const auto farthest = [&](auto&& distance) {
    Vec3 best = o;
    double most = 0;
    for (const Vec3& q : p)
      if (const double d = distance(Vec3(q - o)); d > most) most = d, best = q;
    meter.spend(pass_over(p.size()));
    return std::pair(Vec3(best - o), most);
  };
  const auto [first, d1] = farthest([](const Vec3& v) { return v.norm(); });
  f.extent[0] = d1;
  if (d1 == 0) return f;
  const Vec3 e1 = first / d1;
  const auto [second, d2] = farthest([&](const Vec3& v) { return v.cross(e1).norm(); });
  f.extent[1] = d2;
  Vec3 e2 = second - e1 * e1.dot(second);
  e2 = d2 > tolerance::flat_hull * d1 ? Vec3((e2 - e1 * e1.dot(e2)).normalized()) : any_normal(e1);
  const Vec3 e3 = e1.cross(e2).normalized();
  f.extent[2] = farthest([&](const Vec3& v) { return std::abs(v.dot(e3)); }).second;
  f.axes << e1.transpose(), e2.transpose(), e3.transpose();
  return f;
}

using FlatPoints = std::span<const std::array<double, 2>>;

// The polygon without the corners that lie, to rounding, between their neighbours on one edge. The heights above it of
// all corners left out of an edge add up to at most `rounding`, metres.
std::vector<std::uint32_t> without_flat_corners(const std::vector<std::uint32_t>& loop, FlatPoints q, double rounding) {
  std::vector<std::uint32_t> kept;
  double lost = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint32_t last = kept.empty() ? loop.front() : kept.front();
    const auto &a = q[kept.empty() ? loop.back() : kept.back()], &b = q[loop[i]],
               &c = q[i + 1 < loop.size() ? loop[i + 1] : last];
    const double u = b[0] - a[0], v = b[1] - a[1], x = c[0] - a[0], y = c[1] - a[1];
    const double height = (u * y - v * x) / std::sqrt(x * x + y * y);
    const bool between = u * x + v * y > 0 && (x - u) * x + (y - v) * y > 0;
    if (between && lost + height <= rounding) {
      lost += height;
    } else {
      kept.push_back(loop[i]);
      lost = 0;
    }
  }
  return kept;
}

// Andrew's monotone chain; counterclockwise in the frame's plane, without collinear points.
std::vector<std::uint32_t> flat_loop(std::span<const Vec3> p, const Frame& f) {
  std::vector<std::array<double, 2>> q(p.size());
  std::vector<std::uint32_t> order(p.size());
  for (std::uint32_t i = 0; i < p.size(); ++i) {
    const Vec3 v = f.axes * (p[i] - p[f.origin]);
    q[i] = {v.x(), v.y()};
    order[i] = i;
  }
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return q[a] < q[b]; });
  std::vector<std::uint32_t> loop;
  const auto chain = [&](auto begin, auto end) {
    const std::size_t base = loop.size();
    for (auto it = begin; it != end; ++it) {
      while (loop.size() >= base + 2) {
        const auto &a = q[loop[loop.size() - 2]], &b = q[loop.back()], &c = q[*it];
        if ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0) break;
        loop.pop_back();
      }
      loop.push_back(*it);
    }
    loop.pop_back();  // the other chain starts there
  };
  chain(order.begin(), order.end());
  chain(order.rbegin(), order.rend());
  return without_flat_corners(loop, q, 4 * epsilon * f.extent[0]);
}

// The directed edges of loops, sorted, with the face to the left of each.
class EdgeFaces {
 public:
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  explicit EdgeFaces(std::size_t size) { rows_.reserve(size); }
  void add(std::uint32_t from, std::uint32_t to, std::uint32_t face) { rows_.push_back({{from, to}, face}); }
  void sort(WorkMeter& meter) { sort_metered(meter, rows_.begin(), rows_.end(), std::less<Row>()); }
  using Row = std::pair<Edge, std::uint32_t>;
  const std::vector<Row>& rows() const { return rows_; }
  /// Null if there is none.
  const std::uint32_t* find(const Edge& edge) const {
    const auto at = std::lower_bound(rows_.begin(), rows_.end(), std::pair(edge, 0u));
    return at != rows_.end() && at->first == edge ? &at->second : nullptr;
  }

 private:
  std::vector<Row> rows_;
};

// True if every directed edge occurs once, and its reverse, too.
bool closed(const Loops& loops, WorkMeter& meter) {
  EdgeFaces edges(4 * loops.size());
  for (const auto& loop : loops) {
    meter.spend();
    if (loop.size() < 3) return false;
    for (std::size_t k = 0; k < loop.size(); ++k) edges.add(loop[k], loop[(k + 1) % loop.size()], 0);
  }
  edges.sort(meter);
  const auto& rows = edges.rows();
  if (std::adjacent_find(rows.begin(), rows.end()) != rows.end()) return false;
  return !loops.empty() && std::all_of(rows.begin(), rows.end(), [&](const auto& row) {
    meter.spend();
    return edges.find({row.first.second, row.first.first}) != nullptr;
  });
}

// Frees the memory of Qhull, without the struct itself.
struct QhullFree {
  void operator()(qhT* qh) const {
    int current, total;
    qh_freeqhull(qh, !qh_ALL);
    qh_memfreeshort(qh, &current, &total);
  }
};

// Facets that Qhull makes between two checks of a limit: some 50 us.
constexpr int facets_a_check = 32;

// The corners of a large facet. Qhull reads them all for each point that it merges into the facet, and takes such a
// facet up last, even if points lie above it.
constexpr int many_corners = 256;

bool has_large_facet(qhT* qh) {
  const facetT* facet;
  FORALLfacets if (qh_setsize(qh, facet->vertices) >= many_corners) return true;
  return false;
}

// The stream that Qhull requires for errors and reports; it prints nothing. Qhull reports every few facets (option TF),
// and its output is the occasion to check the limit and, whenever the vertices have doubled, for large facets: option
// TA, which Qhull reads before each point, is then set to the number of points added.
class Log {
 public:
  Log(qhT* qh, const WorkLimit* limit, bool ends_at_large) : qh_(qh), limit_(limit), ends_at_large_(ends_at_large) {
    if (!stream_) throw std::bad_alloc();
    std::setvbuf(stream_, nullptr, _IONBF, 0);
  }
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  ~Log() { std::fclose(stream_); }

  std::FILE* stream() const { return stream_; }
  /// After Qhull has returned: throws the exception that ended it.
  void require_whole() const {
    if (failure_) std::rethrow_exception(failure_);
    if (stopped_) throw WorkStopped();
  }
  /// True if a large facet has ended Qhull.
  bool large_facet() const { return large_facet_; }

 private:
  static ssize_t write(void* log, const char*, std::size_t size) {
    static_cast<Log*>(log)->check_limit();
    static_cast<Log*>(log)->check_facets();
    return static_cast<ssize_t>(size);
  }
  // No exception may pass through Qhull.
  void check_limit() noexcept {
    if (limit_ == nullptr || stopped_ || failure_) return;
    try {
      stopped_ = limit_->reached();
    } catch (...) {
      failure_ = std::current_exception();
    }
    if (stopped_ || failure_) qh_->STOPadd = 1;
  }
  void check_facets() {
    if (!ends_at_large_ || qh_->num_vertices < next_) return;
    next_ = 2 * qh_->num_vertices;
    large_facet_ = has_large_facet(qh_);
    if (large_facet_) qh_->STOPadd = 1;
  }

  qhT* const qh_;
  const WorkLimit* const limit_;
  const bool ends_at_large_;
  int next_ = many_corners;  // vertices at the next check for large facets
  bool large_facet_ = false, stopped_ = false;
  std::exception_ptr failure_;
  std::FILE* const stream_ =
      fopencookie(this, "w", {.read = nullptr, .write = write, .seek = nullptr, .close = nullptr});
};

// Qhull's facets, counterclockwise from outside.
Loops read_loops(qhT* qh, WorkMeter& meter) {
  Loops loops;
  facetT* facet;
  FORALLfacets {
    meter.spend(4);
    setT* around = qh_facet3vertex(qh, facet);
    vertexT *vertex, **vertexp;
    std::vector<std::uint32_t> loop;
    FOREACHvertex_(around) loop.push_back(static_cast<std::uint32_t>(qh_pointid(qh, vertex->point)));
    qh_settempfree(qh, &around);
    loops.push_back(std::move(loop));
  }
  return loops;
}

// Qhull gives all loops the same orientation, but not a known one: turns them counterclockwise from outside.
void orient(Loops& loops, const std::vector<double>& xyz) {
  Vec3 sum = Vec3::Zero();
  const auto at = [&](std::uint32_t i) { return Vec3(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]); };
  for (const auto& loop : loops) sum += at(loop[0]);
  const Vec3 inside = sum / static_cast<double>(loops.size());
  double volume = 0;
  for (const auto& loop : loops)
    for (std::size_t k = 2; k < loop.size(); ++k)
      volume += (at(loop[0]) - inside).dot((at(loop[k - 1]) - inside).cross(at(loop[k]) - inside));
  if (volume < 0)
    for (auto& loop : loops) std::reverse(loop.begin(), loop.end());
}

// The height of an apex above its facet, relative to the radius of that. More: it is above neighbours of the facet that
// are little inclined, too. Less: the triangles about it are coplanar to rounding.
constexpr double apex_height = 1.0 / 64;

// A point above a large facet, which splits it into triangles while Qhull builds, and the plane of that facet.
struct Apex {
  std::array<double, 3> at;
  Vec3 normal;
  double offset;
};

// Finds the apex of a facet; false if a point lies outside of its plane.
bool find_apex(qhT* qh, const facetT* facet, const std::vector<double>& xyz, Apex& apex) {
  apex.normal = Vec3(facet->normal[0], facet->normal[1], facet->normal[2]);
  apex.offset = -facet->offset;
  for (std::size_t i = 0; i < xyz.size(); i += 3)
    if (apex.normal.dot(Vec3(xyz[i], xyz[i + 1], xyz[i + 2])) > apex.offset + tolerance::flat_hull) return false;
  Vec3 sum = Vec3::Zero();
  vertexT *vertex, **vertexp;
  const auto at = [](const vertexT* v) { return Vec3(v->point[0], v->point[1], v->point[2]); };
  FOREACHvertex_(facet->vertices) sum += at(vertex);
  const Vec3 middle = sum / qh_setsize(qh, facet->vertices);
  double radius = 0;
  FOREACHvertex_(facet->vertices) radius = std::max(radius, (at(vertex) - middle).norm());
  const Vec3 high = middle + apex_height * radius * apex.normal;
  apex.at = {high.x(), high.y(), high.z()};
  return true;
}

// Large facets that have points above come first, others get an apex.
void split_large_facets(qhT* qh, const std::vector<double>& xyz, std::deque<Apex>& apexes, WorkMeter& meter) {
  std::vector<facetT*> large;
  facetT* facet;
  FORALLfacets if (qh_setsize(qh, facet->vertices) >= many_corners) large.push_back(facet);
  for (facetT* const each : large) {
    meter.spend(pass_over(xyz.size() / 3));
    Apex apex;
    if (qh_setsize(qh, each->outsideset) > 0) {
      qh_removefacet(qh, each);
      qh_prependfacet(qh, each, &qh->facet_list);
    } else if (find_apex(qh, each, xyz, apex)) {
      apexes.push_back(apex);
    }
  }
}

enum class Built { in_part, whole, refused };

// Adds the apexes from `first` on, and then points as qh_buildhull does until the vertices have doubled. Qhull jumps
// out of it for errors: it has no destructors.
Built build_on(qhT* qh, std::deque<Apex>& apexes, std::size_t first) {
  if (setjmp(qh->errexit) != 0) {
    qh->NOerrexit = True;
    return Built::refused;
  }
  qh->NOerrexit = False;
  for (std::size_t i = first; i < apexes.size(); ++i) {
    double distance;
    boolT outside;
    facetT* const facet = qh_findbestfacet(qh, apexes[i].at.data(), !qh_ALL, &distance, &outside);
    qh_addpoint(qh, apexes[i].at.data(), facet, True);  // numbers it even if it is not outside
  }
  Built built = Built::in_part;
  qh->facet_next = qh->facet_list;
  for (const int end = 2 * qh->num_vertices; qh->num_vertices < end && qh->STOPadd == 0;) {
    facetT* facet;
    pointT* const furthest = qh_nextfurthest(qh, &facet);
    if (furthest == nullptr) {
      built = Built::whole;
      break;
    }
    --qh->num_outside;
    qh_addpoint(qh, furthest, facet, qh->ONLYmax);
  }
  qh->NOerrexit = True;
  return built;
}

// Makes the first simplex. False if Qhull refuses the points.
bool start(qhT* qh, std::vector<double>& xyz, std::string& command, Log& log) {
  char* no_arguments[] = {command.data(), nullptr};
  qh_init_A(qh, nullptr, log.stream(), log.stream(), 1, no_arguments);
  if (setjmp(qh->errexit) != 0) {
    qh->NOerrexit = True;
    return false;
  }
  qh->NOerrexit = False;
  qh_initflags(qh, command.data());
  qh_init_B(qh, xyz.data(), static_cast<int>(xyz.size() / 3), 3, False);
  qh_initbuild(qh);
  qh->NOerrexit = True;
  return true;
}

// Joins the loops about an apex into the facet below it. False if corners around the apex do not lie on that facet: it
// is then above others, too.
bool join_about(Loops& loops, std::uint32_t number, const Apex& apex, const std::vector<double>& xyz) {
  constexpr std::uint32_t none = 0xffffffff;
  std::vector<std::uint32_t> next(xyz.size() / 3, none);
  std::uint32_t begin = none, arcs = 0;
  for (auto& loop : loops) {
    const auto at = std::find(loop.begin(), loop.end(), number);
    if (at == loop.end()) continue;
    std::rotate(loop.begin(), at, loop.end());
    for (std::size_t k = 1; k < loop.size(); ++k) {
      const std::uint32_t i = loop[k];
      if (i >= next.size()) return false;  // another apex
      const Vec3 p(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]);
      if (std::abs(apex.normal.dot(p) - apex.offset) > tolerance::flat_hull) return false;
      if (k + 1 == loop.size()) continue;
      next[i] = loop[k + 1];
      begin = i, ++arcs;
    }
    loop.clear();
  }
  if (begin == none) return true;
  std::vector<std::uint32_t> joined;
  for (std::uint32_t i = begin; i != none; i = std::exchange(next[i], none)) joined.push_back(i);
  if (joined.size() != arcs + 1 || joined.back() != begin) return false;
  joined.pop_back();
  std::erase_if(loops, [](const auto& loop) { return loop.empty(); });
  loops.push_back(std::move(joined));
  return true;
}

// The facets where some have many corners: these are split by points above them while Qhull builds, and joined
// afterwards. Empty if Qhull refuses the points, or if a point above a facet is above its neighbours, too.
Loops split_loops(std::vector<double>& xyz, std::string command, const WorkLimit* limit) {
  WorkMeter meter(limit);
  std::deque<Apex> apexes;  // Qhull refers to them
  const auto memory = std::make_unique<qhT>();
  Log log(memory.get(), limit, false);
  const std::unique_ptr<qhT, QhullFree> owner(memory.get());
  qhT* const qh = owner.get();
  qh_zero(qh, log.stream());
  if (!start(qh, xyz, command, log)) return {};
  for (std::size_t added = 0;;) {
    const Built built = build_on(qh, apexes, added);
    log.require_whole();
    if (built == Built::refused) return {};
    if (built == Built::whole) break;
    added = apexes.size();
    split_large_facets(qh, xyz, apexes, meter);
  }
  Loops loops = read_loops(qh, meter);
  std::vector<double> all = xyz;
  for (const Apex& apex : apexes) all.insert(all.end(), apex.at.begin(), apex.at.end());
  orient(loops, all);
  for (std::uint32_t i = 0; i < apexes.size(); ++i)
    if (!join_about(loops, static_cast<std::uint32_t>(xyz.size() / 3) + i, apexes[i], xyz)) return {};
  return loops;
}

// The facets by Qhull, counterclockwise from outside. Empty if Qhull refuses the points. `split_large`: false if facets
// with many corners may take quadratic time.
Loops qhull_loops(std::vector<double>& xyz, const char* options, bool split_large, const WorkLimit* limit) {
  WorkMeter meter(limit);
  std::string command = options;
  if (limit != nullptr || split_large) command += " TF" + std::to_string(facets_a_check);
  {
    const auto memory = std::make_unique<qhT>();
    Log log(memory.get(), limit, split_large);  // outlives Qhull's memory, which refers to the stream
    const std::unique_ptr<qhT, QhullFree> owner(memory.get());
    qhT* const qh = owner.get();
    qh_zero(qh, log.stream());
    const int points = static_cast<int>(xyz.size() / 3);
    const int error = qh_new_qhull(qh, 3, points, xyz.data(), False, command.data(), nullptr, log.stream());
    log.require_whole();
    if (!log.large_facet()) {
      if (error != 0) return {};
      Loops loops = read_loops(qh, meter);
      orient(loops, xyz);
      return loops;
    }
  }
  if (Loops loops = split_loops(xyz, command, limit); closed(loops, meter)) return loops;
  return qhull_loops(xyz, options, false, limit);
}

Loops polytope_loops(std::span<const Vec3> p, const Frame& f, const WorkLimit* limit) {
  WorkMeter meter(limit);
  // An affine map does not change which points are extreme, so the points are scaled to a cube: a plate is then as good
  // as a ball.
  std::vector<double> xyz;
  xyz.reserve(3 * p.size());
  for (const Vec3& v : p) {
    const Vec3 s = (f.axes * (v - p[f.origin])).cwiseQuotient(f.extent);
    xyz.insert(xyz.end(), {s.x(), s.y(), s.z()});
  }
  meter.spend(pass_over(p.size()));
  // Merged facets first; if merging fails, triangles of the joggled points, whose vertices are still input points.
  const char* const merged = "qhull Qs Pp";
  for (const char* options : {merged, "qhull Qs Qt Pp", "qhull QJ Pp"}) {
    std::vector<double> copy = xyz;
    if (Loops loops = qhull_loops(copy, options, options == merged, limit); closed(loops, meter)) return loops;
    meter.spend(pass_over(p.size()));
  }
  return {};
}

EdgeFaces find_faces(const Hull& hull, WorkMeter& meter) {
  EdgeFaces face_of(hull.loop.size());
  for (std::uint32_t i = 0; i < hull.faces.size(); ++i) {
    meter.spend();
    const Hull::Face& face = hull.faces[i];
    for (std::uint32_t k = 0; k < face.count; ++k)
      face_of.add(hull.loop[face.first + k], hull.loop[face.first + (k + 1) % face.count], i);
  }
  face_of.sort(meter);
  return face_of;
}

void add_edges(Hull& hull, const EdgeFaces& face_of, WorkMeter& meter) {
  for (const auto& [v, face] : face_of.rows())
    if (meter.spend(); v.first < v.second)
      hull.edges.push_back({{v.first, v.second}, {face, *face_of.find({v.second, v.first})}});
}

void add_neighbours(Hull& hull, WorkMeter& meter) {
  std::vector<std::vector<std::uint32_t>> near(hull.vertices.size());
  for (const auto& edge : hull.edges) {
    near[edge.v[0]].push_back(edge.v[1]);
    near[edge.v[1]].push_back(edge.v[0]);
  }
  hull.neighbour_first.push_back(0);
  for (auto& list : near) {
    meter.spend();
    std::sort(list.begin(), list.end());
    hull.neighbours.insert(hull.neighbours.end(), list.begin(), list.end());
    hull.neighbour_first.push_back(static_cast<std::uint32_t>(hull.neighbours.size()));
  }
}

void put_in_turn(Hull& hull, const EdgeFaces& face_of, WorkMeter& meter) {
  std::vector<std::uint32_t> faces;
  for (std::uint32_t v = 0; v < hull.vertices.size(); ++v) {
    const std::uint32_t first = hull.neighbour_first[v], end = hull.neighbour_first[v + 1];
    std::vector<std::uint32_t> ring{hull.neighbours[first]};
    for (;;) {
      meter.spend();
      const std::uint32_t face = *face_of.find({v, ring.back()});
      faces.push_back(face);
      const auto begin = hull.loop.begin() + hull.faces[face].first;
      const auto at = std::find(begin, begin + hull.faces[face].count, v);
      const std::uint32_t next = *(at == begin ? begin + hull.faces[face].count - 1 : at - 1);
      if (next == ring.front() || ring.size() == end - first) break;
      ring.push_back(next);
    }
    if (ring.size() != end - first) return;
    std::copy(ring.begin(), ring.end(), hull.neighbours.begin() + first);
  }
  hull.neighbour_face = std::move(faces);
}

// Moves the face's plane out to the farthest vertex.
void extend_offset(const Hull& hull, Hull::Face& face) {
  const auto extend = [&](const Vec3& v) { face.offset = std::max(face.offset, face.normal.dot(v)); };
  if (hull.support.empty()) {
    std::for_each(hull.vertices.begin(), hull.vertices.end(), extend);
    return;
  }
  extend(hull.vertices[support_kernel()(hull.support, hull.vertices.data(), face.normal.data())]);
}

// The area vector of a face, twice as long as its area, and the longest of its sides and diagonals from the first
// corner. The cross products' errors of rounding along that one are removed: what is left of them rotates a narrow
// face's plane about it, and its corners are near that axis.
struct FaceArea {
  Vec3 longest = Vec3::Zero(), vector = Vec3::Zero();

  FaceArea(std::span<const Vec3> p, const std::vector<std::uint32_t>& loop) {
    const Vec3 base = p[loop[0]];
    const auto try_longer = [&](const Vec3& v) {
      if (v.squaredNorm() > longest.squaredNorm()) longest = v;
    };
    for (std::size_t k = 2; k < loop.size(); ++k) {
      vector += (p[loop[k - 1]] - base).cross(p[loop[k]] - base);
      try_longer(p[loop[k - 1]] - base);
      try_longer(p[loop[k]] - base);
      try_longer(p[loop[k]] - p[loop[k - 1]]);
    }
    vector = perpendicular_part(vector, longest);
  }

  // True if the direction is noise.
  bool is_sliver() const { return !(vector.norm() > tolerance::no_area * longest.squaredNorm()); }
};

// Collinear corners are an edge between the surrounding faces: such a face gets a normal between theirs. `slivers`: the
// numbers of these faces.
void set_sliver_normals(Hull& hull, const EdgeFaces& face_of, std::vector<std::uint32_t> slivers) {
  for (const std::uint32_t i : slivers) hull.faces[i].normal.setZero();
  for (bool turned = true; turned && !slivers.empty();) {
    turned = false;
    std::vector<std::uint32_t> left;
    for (const std::uint32_t i : slivers) {
      Hull::Face& face = hull.faces[i];
      Vec3 sum = Vec3::Zero();
      for (std::uint32_t k = 0; k < face.count; ++k)
        sum +=
            hull.faces[*face_of.find({hull.loop[face.first + (k + 1) % face.count], hull.loop[face.first + k]})].normal;
      if (!(sum.norm() > tolerance::parallel_lines)) {
        left.push_back(i);
        continue;
      }
      face.normal = sum.normalized();
      face.offset = face.normal.dot(hull.vertices[hull.loop[face.first]]);
      extend_offset(hull, face);
      turned = true;
    }
    slivers = left;
  }
}

double inner_radius(const Hull& hull) {
  double least = std::numeric_limits<double>::infinity(), reach = 0;
  for (const Hull::Face& f : hull.faces) least = std::min(least, f.offset - f.normal.dot(hull.inside));
  for (const Vec3& v : hull.vertices) reach = std::max(reach, v.norm());
  return std::max(0.0, least - tolerance::inner_ball_lacks * reach);
}

FaceTable make_face_table(const Hull& hull) {
  FaceTable t;
  const std::size_t n = hull.faces.size();
  if (n > FaceTable::most_faces || hull.vertices.size() > FaceTable::most_vertices || hull.support.empty()) return t;
  t.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Hull::Face& f = hull.faces[i];
    t.set(i, f.normal, (f.offset - f.normal.dot(hull.inside)) / hull.support.unit());
  }
  const auto small = [](std::uint32_t i) { return static_cast<std::uint8_t>(i); };
  for (const Hull::Edge& e : hull.edges)
    t.arcs.push_back({{small(e.v[0]), small(e.v[1])}, {small(e.face[0]), small(e.face[1])}});
  return t;
}

Hull assemble(std::span<const Vec3> p, int dimension, const std::vector<std::uint32_t>& extreme, const Loops& loops,
              const Vec3& flat_normal, WorkMeter& meter) {
  Hull hull;
  hull.dimension = dimension;
  std::vector<std::uint32_t> place(p.size());
  std::vector<std::uint32_t> kept = extreme;
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t i : kept) {
    place[i] = static_cast<std::uint32_t>(hull.vertices.size());
    hull.vertices.push_back(p[i]);
    sum += p[i] - p[kept[0]];
  }
  hull.inside = p[kept[0]] + sum / static_cast<double>(kept.size());
  if (hull.vertices.size() > 4) hull.support = SupportMap(hull.vertices, hull.inside, meter);
  std::vector<std::uint32_t> slivers;
  for (const auto& loop : loops) {
    Hull::Face face{Vec3::Zero(), 0, static_cast<std::uint32_t>(hull.loop.size()),
                    static_cast<std::uint32_t>(loop.size())};
    if (dimension == 3) {
      const FaceArea area(p, loop);
      if (area.is_sliver()) slivers.push_back(static_cast<std::uint32_t>(hull.faces.size()));
      face.normal = area.vector.normalized();
    } else {
      face.normal = hull.faces.empty() ? flat_normal : Vec3(-flat_normal);
      face.normal.normalize();
    }
    meter.spend();
    for (const std::uint32_t i : loop) hull.loop.push_back(place[i]);
    face.offset = face.normal.dot(p[loop[0]]);
    extend_offset(hull, face);
    hull.faces.push_back(face);
  }
  if (dimension == 1) hull.edges.push_back({{0, 1}, {0, 0}});
  const int pass = pass_over(16 * hull.loop.size());
  const EdgeFaces face_of = find_faces(hull, meter);
  set_sliver_normals(hull, face_of, slivers);
  if (dimension == 3) hull.inner_radius = inner_radius(hull);
  add_edges(hull, face_of, meter);
  add_neighbours(hull, meter);
  if (dimension == 3) put_in_turn(hull, face_of, meter);
  if (dimension == 3) hull.face_table = make_face_table(hull);
  meter.spend(pass);
  if (hull.inner_radius > 0) hull.rays = map_rays(hull);
  meter.spend(pass);
  if (hull.face_table.faces == 0 && hull.faces.size() > 4) {
    std::vector<Vec3> normals;
    for (const Hull::Face& face : hull.faces) normals.push_back(face.normal);
    hull.normals = SupportMap(normals, Vec3::Zero(), meter);
  }
  return hull;
}

}  // namespace

std::size_t Hull::memory() const {
  const auto bytes = [](const auto&... list) { return (std::size_t(0) + ... + (list.capacity() * sizeof(list[0]))); };
  return sizeof(Hull) + bytes(vertices, faces, loop, edges, neighbour_first, neighbours, neighbour_face) +
         support.memory() + normals.memory() + rays.memory() + bytes(face_table.planes, face_table.arcs);
}

Hull build_hull(std::span<const Vec3> points, const WorkLimit* limit) {
  if (points.empty()) throw std::invalid_argument("hull: no points; at least one is needed");
  WorkMeter meter(limit);
  const Frame f = find_frame(points, meter);
  const double flat = tolerance::flat_hull * f.extent[0];
  if (f.extent[0] == 0) return assemble(points, 0, {f.origin}, {}, Vec3::Zero(), meter);

  if (f.extent[1] <= flat) {
    std::uint32_t lo = f.origin, hi = f.origin;
    const auto along = [&](std::uint32_t i) { return f.axes.row(0).dot(points[i] - points[f.origin]); };
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (along(i) < along(lo)) lo = i;
      if (along(i) > along(hi)) hi = i;
    }
    return assemble(points, 1, {lo, hi}, {}, Vec3::Zero(), meter);
  }
  if (f.extent[2] > flat) {
    const Loops loops = polytope_loops(points, f, limit);
    std::vector<std::uint32_t> extreme;
    for (const auto& loop : loops) extreme.insert(extreme.end(), loop.begin(), loop.end());
    if (!loops.empty()) return assemble(points, 3, extreme, loops, Vec3::Zero(), meter);
  }
  const std::vector<std::uint32_t> loop = flat_loop(points, f);
  return assemble(points, 2, loop, {loop, {loop.rbegin(), loop.rend()}}, f.axes.row(2).transpose(), meter);
}

}  // namespace tandem
