#include "meshes/depth/mesh_ways.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "manifold/manifold.h"
#include "meshes/depth/mesh_walls.h"
#include "meshes/traversal/mesh_walk.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

constexpr double rounding = tolerance::place_rounding;  // of places, relative to the size

// What lies in the plane of a triangle about it, in its mesh's frame.
struct FlatFace {
  Corners seed;  // of that triangle
  struct Border {
    Vec3 from, to;
  };
  std::vector<Border> borders;
};

// A straight line of edges.
struct Chain {
  Vec3 from, to;
};

class FlatParts {
 public:
  FlatParts(const MeshModel& mesh, double slack) : mesh_(mesh), slack_(slack) {}

  const FlatFace& face(std::uint32_t t) {
    const auto [place, fresh] = face_of_.try_emplace(t, faces_.size());
    if (fresh) find_face(t);
    return faces_[place->second];
  }

  // The chain of a triangle's edge k.
  const Chain& chain(std::uint32_t t, std::size_t k) {
    const auto [place, fresh] = chains_.try_emplace({t, static_cast<std::uint32_t>(k)});
    if (fresh) {
      const Corners p = mesh_.corners(t);
      const Vec3 along = unit(p[(k + 1) % 3] - p[k]);
      place->second = {end_of_chain(t, k, -along), end_of_chain(t, (k + 1) % 3, along)};
    }
    return place->second;
  }

  // Of the two triangles at an edge that bends the first; none where they lie in one plane.
  bool is_edge(std::uint32_t t, std::size_t k) const {
    const std::uint32_t next = mesh_.neighbours[t][k];
    if (next == no_index) return true;
    if (next < t) return false;
    const Corners p = mesh_.corners(t);
    const Vec3 n = unit((p[1] - p[0]).cross(p[2] - p[0]));
    return !lies_flat(n, p[0], next);
  }

 private:
  static constexpr std::size_t most = 64;  // triangles of a face, edges of a chain, triangles about a corner

  bool lies_flat(const Vec3& n, const Vec3& at, std::uint32_t t) const {
    const Corners c = mesh_.corners(t);
    return std::all_of(c.begin(), c.end(), [&](const Vec3& v) { return std::abs(n.dot(v - at)) <= slack_; }) &&
           n.dot((c[1] - c[0]).cross(c[2] - c[0])) > 0;
  }

  void find_face(std::uint32_t t) {
    const Corners own = mesh_.corners(t);
    const Vec3 n = unit((own[1] - own[0]).cross(own[2] - own[0]));
    FlatFace face{own, {}};
    std::vector<std::uint32_t> flat{t};
    const auto is_known = [&](std::uint32_t i) { return std::find(flat.begin(), flat.end(), i) != flat.end(); };
    for (std::size_t i = 0; i < flat.size() && flat.size() < most; ++i)
      for (const std::uint32_t next : mesh_.neighbours[flat[i]])
        if (flat.size() < most && next != no_index && !is_known(next) && lies_flat(n, own[0], next))
          flat.push_back(next);
    for (const std::uint32_t i : flat) {
      const Corners c = mesh_.corners(i);
      for (std::size_t k = 0; k < 3; ++k)
        if (const std::uint32_t next = mesh_.neighbours[i][k]; next == no_index || !is_known(next))
          face.borders.push_back({c[k], c[(k + 1) % 3]});
    }
    if (flat.size() < most)  // else it would be another one from another triangle
      for (const std::uint32_t i : flat) face_of_[i] = faces_.size();
    faces_.push_back(std::move(face));
  }

  // From a corner of t from edge to edge straight on.
  Vec3 end_of_chain(std::uint32_t t, std::size_t corner, const Vec3& along) const {
    const Vec3 begin = mesh_.corners(t)[corner];
    for (std::size_t step = 0; step < most && go_on(t, corner, begin, along); ++step) {
    }
    return mesh_.corners(t)[corner];
  }

  bool go_on(std::uint32_t& t, std::size_t& corner, const Vec3& begin, const Vec3& along) const {
    const Vec3 here = mesh_.corners(t)[corner];
    std::uint32_t at = t;
    std::size_t c = corner;
    for (std::size_t i = 0; i < most; ++i) {
      const Corners p = mesh_.corners(at);
      for (const std::size_t other : {(c + 1) % 3, (c + 2) % 3}) {
        const Vec3 away = p[other] - begin;
        if (!(along.dot(p[other] - here) > slack_) || (away - along.dot(away) * along).norm() > slack_) continue;
        t = at, corner = other;
        return true;
      }
      const std::uint32_t next = mesh_.neighbours[at][c];
      if (next == no_index || next == t) return false;
      const Corners q = mesh_.corners(next);
      const auto same = std::find(q.begin(), q.end(), here);
      if (same == q.end()) return false;
      at = next, c = static_cast<std::size_t>(same - q.begin());
    }
    return false;
  }

  const MeshModel& mesh_;
  const double slack_;
  std::map<std::uint32_t, std::size_t> face_of_;
  std::vector<FlatFace> faces_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Chain> chains_;
};

// A hold and midway between the points that come together where it ends.
struct HoldAt : Hold {
  Vec3 point;
};

}  // namespace

struct WaysOut::Parts {
  static constexpr std::size_t most_holds = 48, most_pairs = 512;

  Parts(const Posed& first, const Posed& second, MovedPairs meet_at)
      : a(first),
        b(second),
        meet(std::move(meet_at)),
        between(b.pose.translation - a.pose.translation),
        size(a.shape.size() + b.shape.size()),
        slack(rounding * size),
        flat{FlatParts(mesh_of(b.shape), slack), FlatParts(mesh_of(a.shape), slack)} {}

  bool is_out(const Vec3& move) const { return !meet(move, nullptr) && !meet(farther(move), nullptr); }
  Vec3 farther(const Vec3& move) const { return move + alike * size * unit(move, move.norm()); }

  // World axes about A's translation, B moved.
  Vec3 placed(bool of_a, const Vec3& v, const Vec3& at) const {
    return of_a ? Vec3(a.pose.rotation * v) : Vec3(b.pose.rotation * v + between + at);
  }

  void add(const HoldAt& hold) {
    const auto says_more = [&](const HoldAt& x, const HoldAt& y) {
      return x.wall.normal.dot(y.wall.normal) > tolerance::one_direction && x.wall.bound >= y.wall.bound - slack && x.reach >= y.reach;
    };
    if (std::any_of(holds.begin(), holds.end(), [&](const HoldAt& h) { return says_more(h, hold); })) return;
    std::erase_if(holds, [&](const HoldAt& h) { return says_more(hold, h); });
    if (holds.size() < most_holds) holds.push_back(hold), is_new = true;
  }

  // Edge k of triangle i of one mesh, B moved by `at`, through triangle j of the other.
  void look(bool of_a, std::uint32_t i, std::size_t k, std::uint32_t j, const Vec3& at) {
    const MeshModel &own = mesh_of((of_a ? a : b).shape), &other = mesh_of((of_a ? b : a).shape);
    if (!flat[of_a ? 1 : 0].is_edge(i, k)) return;
    const Corners edges = own.corners(i), corners = other.corners(j);
    const Vec3 p = placed(of_a, edges[k], at), q = placed(of_a, edges[(k + 1) % 3], at);
    const auto all_placed = [&](const Corners& c) {
      return Corners{placed(!of_a, c[0], at), placed(!of_a, c[1], at), placed(!of_a, c[2], at)};
    };
    const FlatFace& face = flat[of_a ? 0 : 1].face(j);
    const Corners t = all_placed(corners), seed = all_placed(face.seed);
    const Vec3 area = (seed[1] - seed[0]).cross(seed[2] - seed[0]);
    const double length = area.norm();
    if (!(length > 0)) return;
    const Vec3 n = unit(area, length);
    const double from = n.dot(p - seed[0]), to = n.dot(q - seed[0]);
    if (!(from * to < 0)) return;
    const Vec3 c = p + from / (from - to) * (q - p);
    for (std::size_t e = 0; e < 3; ++e) {
      const Vec3 side = t[(e + 1) % 3] - t[e];
      if (!(n.cross(side).dot(c - t[e]) >= -slack * side.norm())) return;
    }
    add_holds(of_a, flat[of_a ? 1 : 0].chain(i, k), face, n, c, at);
  }

  // A chain through the inside of a face at c, n its normal. It leaves the face with one of its ends or over a border:
  // of the half disc about c on the inner side of a border's line all lies in the face that no other border comes into.
  void add_holds(bool of_a, const Chain& chain, const FlatFace& face, const Vec3& n, const Vec3& c, const Vec3& at) {
    constexpr std::size_t most_lines = 4;
    const Vec3 from = placed(of_a, chain.from, at), to = placed(of_a, chain.to, at), u = unit(to - from);
    const double low = n.dot(from - c), high = n.dot(to - c), slope = n.dot(u);
    if (!(std::abs(slope) > tolerance::flush)) return;
    borders.clear();
    for (const FlatFace::Border& border : face.borders) {
      const Vec3 p = placed(!of_a, border.from, at), q = placed(!of_a, border.to, at), d = q - p;
      const double length2 = d.squaredNorm();
      // A border too short to be squared is a point.
      const double part = length2 > 0 ? std::clamp((c - p).dot(d) / length2, 0.0, 1.0) : 0;
      borders.push_back({p, q, (p + part * d - c).norm()});
    }
    const std::size_t lines = std::min(most_lines, borders.size());
    std::partial_sort(borders.begin(), borders.begin() + static_cast<std::ptrdiff_t>(lines), borders.end(),
                      [](const Border& x, const Border& y) { return x.distance < y.distance; });
    const double ends = std::min(std::abs(low), std::abs(high));
    // `way`: of the chain relative to the face; it leaves the face at `place`.
    const auto add_one = [&](const Vec3& way, double bound, double reach, const Vec3& place) {
      const Vec3 normal = of_a ? Vec3(-way) : way;
      const Hold hold{{normal, normal.dot(at) + bound}, reach - at.norm()};
      if (hold.wall.bound > 0 && hold.reach > hold.wall.bound) add({hold, place - (bound * way + at) / 2});
    };
    const double inside = borders.empty() ? 0 : borders.front().distance * std::abs(slope);
    add_one(low < 0 ? n : Vec3(-n), std::abs(low), std::min(std::abs(high), inside), from - low * n);
    add_one(high < 0 ? n : Vec3(-n), std::abs(high), std::min(std::abs(low), inside), to - high * n);
    for (const Border& line : std::span(borders).first(lines)) {
      const Vec3 inward = n.cross(unit(line.to - line.from));
      const double beside = inward.dot(c - line.from);
      double reach = ends;
      for (const Border& other : borders)
        if (inward.dot(other.from - line.from) > slack || inward.dot(other.to - line.from) > slack)
          reach = std::min(reach, other.distance * std::abs(slope));
      const Vec3 across = inward - (inward.dot(u) / slope) * n;
      const double steep = across.norm();
      if (!(beside > 0)) continue;
      const Vec3 way = -across / steep;
      const double bound = beside / steep;
      add_one(way, bound, reach, c + bound * (way - (n.dot(way) / slope) * u));
    }
  }

  // Adds the holds about pairs of triangles that meet with B moved by `at`. False: no way leads past them all.
  bool look_at(std::span<const std::array<std::uint32_t, 2>> pairs, const Vec3& at) {
    constexpr std::size_t at_once = 16;  // many that oppose each other show early
    for (std::size_t first = 0; first < std::min(pairs.size(), most_pairs); first += at_once) {
      for (const auto& [i, j] : pairs.subspan(first, std::min(at_once, pairs.size() - first)))
        for (std::size_t k = 0; k < 3; ++k) look(true, i, k, j, at), look(false, j, k, i, at);
      if (Vec3 to; !shortest(0, slack, to)) return false;
    }
    return true;
  }

  // The shortest translation beyond what holds at least `reach` far, each wall `more` farther out.
  bool shortest(double reach, double more, Vec3& to) {
    walls.clear();
    for (const HoldAt& h : holds)
      if (h.reach >= reach) walls.push_back({h.wall.normal, h.wall.bound + more});
    std::stable_sort(walls.begin(), walls.end(), [](const Wall& x, const Wall& y) { return x.bound > y.bound; });
    return shortest_beyond(walls, slack / 8, to);
  }

  void make_certain(WayOut& out) {
    if (!std::isfinite(out.length)) return;
    // What holds not that far may hold half as far.
    constexpr double least = 0.01;
    for (double far = out.length; far > std::max(out.certain, least * out.length); far /= 2)
      if (Vec3 to; shortest(far, 0, to)) out.certain = std::max(out.certain, std::min(far, to.norm()));
  }

  // The walls that part each triangle of B, moved by `at`, from each of A less than `reach` away: whatever lies beyond
  // them and no farther from `at` than that parts them, too. False: two touch, or it would be too much work.
  bool walls_about(const Vec3& at, double reach, std::size_t& work_left) {
    constexpr std::size_t most = 64;
    struct Plane {
      Vec3 n, of_a, of_b;  // world axes; A's and B's, absolute
      double gap;
    };
    std::vector<Plane> planes;
    walls.clear();
    const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
    const Mat3 &turn_a = a.pose.rotation, &turn_b = b.pose.rotation;
    const Vec3 shift = between + at;
    const double far = reach + tolerance::askew_place * size;  // rotations may be a little off
    // Does a plane that is known part them by its gap? The last that did is asked first.
    std::size_t last = 0;
    const auto is_parted = [&](auto&& gap_along) {
      if (last < planes.size() && gap_along(planes[last]) >= planes[last].gap) return true;
      for (std::size_t k = 0; k < planes.size(); ++k)
        if (k != last && gap_along(planes[k]) >= planes[k].gap) {
          last = k;
          return true;
        }
      return false;
    };
    std::vector<std::pair<std::uint32_t, std::uint32_t>> stack{{whole, whole}};
    while (!stack.empty()) {
      const std::uint32_t x = stack.back().first, y = stack.back().second;
      stack.pop_back();
      const BoxOf box_a(ma, x), box_b(mb, y);
      const Vec3 d = turn_b * box_b.mid + shift - turn_a * box_a.mid;
      if (d.norm() - box_a.half.norm() - box_b.half.norm() > far) continue;
      if (is_parted([&](const Plane& plane) {
            return plane.n.dot(d) - plane.of_a.dot(box_a.half) - plane.of_b.dot(box_b.half);
          }))
        continue;
      if (work_left == 0) return false;
      --work_left;
      const bool leaf_a = is_leaf(ma, x), leaf_b = is_leaf(mb, y);
      if (leaf_b ? !leaf_a : !leaf_a && box_a.half.squaredNorm() >= box_b.half.squaredNorm()) {
        each_child(ma, x, [&](std::uint32_t child) { stack.emplace_back(child, y); });
        continue;
      }
      if (!leaf_b) {
        each_child(mb, y, [&](std::uint32_t child) { stack.emplace_back(x, child); });
        continue;
      }
      bool parted = true;
      each_triangle(ma, x, [&](std::uint32_t i) {
        each_triangle(mb, y, [&](std::uint32_t j) {
          if (!parted) return;
          Corners s = ma.corners(i), t = mb.corners(j);
          for (std::size_t k = 0; k < 3; ++k) s[k] = placed(true, s[k], at), t[k] = placed(false, t[k], at);
          const auto gap_along = [&](const Vec3& n) {
            return std::min({n.dot(t[0]), n.dot(t[1]), n.dot(t[2])}) -
                   std::max({n.dot(s[0]), n.dot(s[1]), n.dot(s[2])});
          };
          if (is_parted([&](const Plane& plane) { return gap_along(plane.n); })) return;
          const Pose none;
          const PairAnswer r =
              solve_convex(TriangleView(s), none, TriangleView(t), none, Request::distance, {}, nullptr);
          if (r.signed_distance > reach) return;
          const double gap = gap_along(r.normal);
          if (walls.size() == most || !(r.signed_distance > 0 && gap > 0)) {
            parted = false;
            return;
          }
          planes.push_back(
              {r.normal, (turn_a.transpose() * r.normal).cwiseAbs(), (turn_b.transpose() * r.normal).cwiseAbs(), gap});
          walls.push_back({r.normal, r.normal.dot(at) - gap});
        });
      });
      if (!parted) return false;
    }
    return true;
  }

  const Posed a, b;
  const MovedPairs meet;
  const Vec3 between;
  const double size, slack;
  std::array<FlatParts, 2> flat;  // of B, of A
  std::vector<HoldAt> holds;
  struct Border {
    Vec3 from, to;
    double distance;
  };
  std::vector<Border> borders;
  bool is_new = false;
  std::vector<Wall> walls;
  Pairs found;
};

WaysOut::WaysOut(const Posed& a, const Posed& b, MovedPairs meet)
    : parts_(std::make_unique<Parts>(a, b, std::move(meet))) {}
WaysOut::~WaysOut() = default;

bool WaysOut::is_out(const Vec3& direction, double length) const { return parts_->is_out(length * direction); }

void WaysOut::leave_walls(std::span<const std::array<std::uint32_t, 2>> pairs, WayOut& out) {
  constexpr int rounds = 8;
  Parts& p = *parts_;
  Vec3 at = Vec3::Zero();
  bool leads_on = p.look_at(pairs, at);
  for (int i = 0; i < rounds && leads_on && p.is_new; ++i) {
    p.is_new = false;
    if (!p.shortest(0, p.slack, at) || !(at.norm() > 0 && at.norm() < out.length)) break;
    const Vec3 farther = p.farther(at);
    if (const bool meet = p.meet(at, &p.found); meet || p.meet(farther, &p.found)) {
      leads_on = p.look_at(p.found, meet ? at : farther);
      continue;
    }
    out.length = at.norm();
    out.normal = unit(at, out.length);
    // Where the wall is that is most in the way.
    double most = -infinity;
    for (const HoldAt& h : p.holds)
      if (const double share = h.wall.normal.dot(at); share <= h.wall.bound + 2 * p.slack && share > most)
        most = share, out.point = h.point;
    break;
  }
  p.make_certain(out);
}

void WaysOut::attempt(const Vec3& direction, WayOut& out) {
  constexpr int halvings = 12;
  constexpr double worth_it = 0.999;
  double free = worth_it * out.length, blocked = out.certain;
  if (!(direction.norm() > 0.5) || !is_out(direction, free)) return;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (free + blocked) / 2;
    (is_out(direction, middle) ? free : blocked) = middle;
  }
  out.length = free;
  out.normal = direction;
}

void WaysOut::attempt(std::span<const Contact> contacts, WayOut& out) {
  Parts& p = *parts_;
  p.walls.clear();
  for (const Contact& c : contacts)
    if (p.walls.size() < Parts::most_holds && c.depth > 0) p.walls.push_back({c.normal, c.depth + p.slack});
  Vec3 at;
  if (!shortest_beyond(p.walls, p.slack, at) || !(at.norm() < out.length) || !p.is_out(at)) return;
  out.length = at.norm();
  out.normal = unit(at, out.length);
}

void WaysOut::shorten(WayOut& out) {
  constexpr int rounds = 12;
  std::size_t work = 16384;
  Parts& p = *parts_;
  const double reach = 0.02 * p.size, spare = 4 * p.slack;
  double ahead = tolerance::far_apart * p.size;
  for (int i = 0; i < rounds; ++i, ahead = std::max(0.1 * ahead, tolerance::least_apart * p.size)) {
    const Vec3 at = (out.length + ahead) * out.normal;
    Vec3 to;
    if (!p.walls_about(at, reach, work)) break;
    for (Wall& wall : p.walls) wall.bound += spare;
    if (!shortest_beyond(p.walls, p.slack / 8, to)) break;
    if (const double step = (to - at).norm(); step > reach) to = at + (0.999 * reach / step) * (to - at);
    const double length = to.norm();
    if (!(length > 0 && length < out.length - p.slack) || !p.is_out(to)) break;
    out.length = length;
    out.normal = unit(to, length);
  }
}

void WaysOut::confirm(WayOut& out) {
  Parts& p = *parts_;
  const Vec3 at = (out.length - std::min(0.5 * out.length, tolerance::near_apart * p.size)) * out.normal;
  p.meet(at, &p.found);
  p.look_at(p.found, at);
  p.make_certain(out);
}

}  // namespace tandem
