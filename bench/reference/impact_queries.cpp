// Families of queries for continuous collision detection of vertices on straight lines.
#include "impact_queries.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tandem::reference {
namespace {

Vec3 grid(Random& random, int most) {
  const int x = random.below(2 * most + 1) - most, y = random.below(2 * most + 1) - most;
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(random.below(2 * most + 1) - most)};
}

// A random kind of query: a point and a triangle, or two edges.
ImpactQuery either(Random& random) {
  ImpactQuery q;
  q.edges = random.once_in(2);
  return q;
}

template <class Place>
ImpactQuery filled(Random& random, const Place& place) {
  ImpactQuery q = either(random);
  for (Vec3& v : q.from) v = place();
  for (Vec3& v : q.to) v = place();
  return q;
}

// The point with the parameters u, v: of the triangle; or, for edges, u on the second minus v on the first.
Vec3 on_second(const std::array<Vec3, 4>& x, bool edges, double u, double v) {
  if (edges) return x[2] + u * (x[3] - x[2]);
  return (1 - u - v) * x[1] + u * x[2] + v * x[3];
}

ImpactQuery anywhere(Random& random) {
  return filled(random, [&] { return random.vec(0, 1); });
}

// A step of a simulation: features of size 1, nearby, that move by some hundredths.
ImpactQuery step(Random& random) {
  ImpactQuery q = filled(random, [&] { return random.vec(0, 1); });
  const double shift_by = random.power_of_two(-9, -3);
  for (std::size_t i = 0; i < 4; ++i) q.to[i] = q.from[i] + random.vec(-shift_by, shift_by);
  return q;
}

// Features that nearly touch, at gaps of all sizes.
ImpactQuery resting(Random& random) {
  ImpactQuery q = filled(random, [&] { return random.vec(0, 1); });
  const double shift_by = random.power_of_two(-12, -3), gap = random.power_of_two(-34, -5);
  const double u = random.in(-0.1, 1.0), v = q.edges ? random.in(-0.1, 1.1) : random.in(-0.1, 1 - u);
  const Vec3 place = on_second(q.from, q.edges, u, v);
  const Vec3 normal = q.edges ? Vec3((q.from[1] - q.from[0]).cross(q.from[3] - q.from[2]).normalized())
                              : Vec3((q.from[2] - q.from[1]).cross(q.from[3] - q.from[1]).normalized());
  const Vec3 at = place + gap * random.sign() * normal;
  const Vec3 shift = at - (q.edges ? Vec3(q.from[0] + v * (q.from[1] - q.from[0])) : q.from[0]);
  q.from[0] += shift;
  if (q.edges) q.from[1] += shift;
  for (std::size_t i = 0; i < 4; ++i) q.to[i] = q.from[i] + random.vec(-shift_by, shift_by);
  return q;
}

ImpactQuery on_grid(Random& random) {
  const int most = 1 + random.below(4);
  return filled(random, [&] { return grid(random, most); });
}

ImpactQuery short_on_grid(Random& random) {
  ImpactQuery q = filled(random, [&] { return grid(random, 3); });
  for (std::size_t i = 0; i < 4; ++i) q.to[i] = q.from[i] + grid(random, 1);
  return q;
}

// All vertices in one plane, at every time.
ImpactQuery in_plane(Random& random) {
  const Vec3 x = grid(random, 2), y = grid(random, 2), o = grid(random, 3);
  const bool exact = random.once_in(2);
  return filled(random, [&]() -> Vec3 {
    const Vec3 c = exact ? grid(random, 4) : random.vec(-1, 1);
    return o + c.x() * x + c.y() * y;
  });
}

// Coincident vertices, and some that stand still.
ImpactQuery doubled(Random& random) {
  ImpactQuery q = random.once_in(2) ? on_grid(random) : anywhere(random);
  for (int i = 0; i < 2; ++i) {
    const auto a = static_cast<std::size_t>(random.below(4)), b = static_cast<std::size_t>(random.below(4));
    switch (random.below(4)) {
      case 0: q.from[a] = q.from[b]; break;
      case 1: q.to[a] = q.to[b]; break;
      case 2: q.from[a] = q.from[b], q.to[a] = q.to[b]; break;
      default: q.to[a] = q.from[a];
    }
  }
  return q;
}

// Nothing moves, or all by the same translation.
ImpactQuery standing(Random& random) {
  ImpactQuery q = random.once_in(3) ? resting(random) : on_grid(random);
  const Vec3 shift_by = random.once_in(2) ? Vec3::Zero().eval() : grid(random, 2);
  for (std::size_t i = 0; i < 4; ++i) q.to[i] = q.from[i] + shift_by;
  return q;
}

// Touching at t = 0 or t = 1 at a point with parameters of few bits, and mostly separated at other times.
ImpactQuery touching_at_an_end(Random& random) {
  ImpactQuery q = on_grid(random);
  std::array<Vec3, 4>& x = random.once_in(2) ? q.from : q.to;
  const double u = 0.25 * random.below(5),
               v = q.edges ? 0.5 * random.below(3) : 0.25 * random.below(5 - static_cast<int>(4 * u));
  const Vec3 place = on_second(x, q.edges, u, v);
  const Vec3 shift = place - (q.edges ? Vec3(x[0] + v * (x[1] - x[0])) : x[0]);
  x[0] += shift;
  if (q.edges) x[1] += shift;
  return q;
}

// Degenerate triangles and edges, at one end of the motion or throughout.
ImpactQuery without_extent(Random& random) {
  ImpactQuery q = on_grid(random);
  const auto flatten = [&](std::array<Vec3, 4>& x) {
    if (q.edges) x[3] = x[2];
    else x[3] = x[1] + random.below(4) * (x[2] - x[1]);
  };
  const int when = random.below(3);
  if (when != 1) flatten(q.from);
  if (when != 0) flatten(q.to);
  return q;
}

// Edges that stay parallel, points that stay in the triangle's plane; rotated, so that rounding tilts them.
ImpactQuery parallel(Random& random) {
  ImpactQuery q = either(random);
  const Vec3 d = grid(random, 2), o = grid(random, 2), shift = grid(random, 2), shift_by = grid(random, 2);
  const Mat3 turn = random.once_in(2) ? Mat3::Identity().eval() : random.rotation();
  const auto place = [&](std::array<Vec3, 4>& x, const Vec3& by) {
    if (q.edges) {
      x = {o, o + d, o + shift + by, o + shift + by + (1 + random.below(2)) * d};
    } else {
      const Vec3 side = grid(random, 2);
      x = {o + 0.25 * (random.below(9) - 2) * d + 0.25 * (random.below(9) - 2) * side + by, o, o + d, o + side};
    }
    for (Vec3& v : x) v = turn * v;
  };
  place(q.from, Vec3::Zero());
  place(q.to, q.edges ? shift_by : random.once_in(2) ? Vec3::Zero().eval() : shift_by);
  return q;
}

// Erleben's scenes: features of spikes, wedges, cliffs and boxes of tenths, aligned to each other and moved along an
// axis, so that vertices pass on edges and edges on vertices.
ImpactQuery aligned(Random& random) {
  static const std::array<std::array<Vec3, 3>, 6> features{{
      {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 0.5, 0)},       // the top of a box
      {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 0.1, 2)},       // a spike's side, its tip last
      {Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0.05, 0.05, 10)},  // a needle's side
      {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 0, 1)},         // a cliff
      {Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(0.3, 0.5, 0.6)},     // a wedge
      {Vec3(0.1, 0.1, 0), Vec3(0.7, 0.7, 0), Vec3(0.4, 0.4, 0.3)},
  }};
  ImpactQuery q = either(random);
  const auto& a = features[static_cast<std::size_t>(random.below(6))];
  const auto& b = features[static_cast<std::size_t>(random.below(6))];
  const auto first = static_cast<std::size_t>(random.below(3));
  const double unit = std::array{1.0, 0.1, 0.3, 1e-3}[static_cast<std::size_t>(random.below(4))];
  if (q.edges)
    q.from = {a[first], a[(first + 1) % 3], b[0], b[1 + static_cast<std::size_t>(random.below(2))]};
  else
    q.from = {a[first], b[0], b[1], b[2]};
  const Vec3 at = 0.1 * grid(random, 10), shift_by = 0.5 * grid(random, 2);
  const Mat3 turn = random.once_in(3) ? random.rotation() : Mat3::Identity().eval();
  const std::size_t moved = q.edges ? 2 : 1;
  for (std::size_t i = 0; i < moved; ++i) q.from[i] += at;
  for (std::size_t i = 0; i < 4; ++i) {
    q.to[i] = unit * (turn * (i < moved ? Vec3(q.from[i] + shift_by) : q.from[i]));
    q.from[i] = unit * (turn * q.from[i]);
  }
  return q;
}

// A triangle or an edge that rotates far, with the other feature just above it all the time: a contact that lasts.
ImpactQuery turning(Random& random) {
  ImpactQuery q = either(random);
  const Mat3 turn = random.rotation();
  const double angle = random.in(-3, 3), gap = random.power_of_two(-24, -3) * random.sign();
  const Mat3 tilt = Eigen::AngleAxisd(angle, random.direction()).toRotationMatrix();
  const Vec3 inside = q.edges ? Vec3(0, 0.2, gap) : Vec3(0.2, 0.1, gap);
  const Vec3 up = Vec3::UnitY();
  std::array<Vec3, 4> x{inside, Vec3(-1, -1, 0), Vec3(1, -1, 0), up};
  if (q.edges) x = {inside - up, inside + up, Vec3(-1, 0, 0), Vec3(1, 0, 0)};
  const Vec3 shift_by = random.once_in(2) ? Vec3::Zero().eval() : random.vec(-1, 1);
  for (std::size_t i = 0; i < 4; ++i) q.from[i] = turn * x[i], q.to[i] = turn * (tilt * x[i]) + shift_by;
  return q;
}

// Any other family, scaled small or large, or far from the origin.
ImpactQuery elsewhere(Random& random) {
  ImpactQuery q;
  switch (random.below(5)) {
    case 0: q = step(random); break;
    case 1: q = on_grid(random); break;
    case 2: q = in_plane(random); break;
    case 3: q = aligned(random); break;
    default: q = touching_at_an_end(random);
  }
  const double scale = std::ldexp(1.0, random.below(61) - 30);
  const Vec3 shift = random.once_in(2) ? Vec3::Zero().eval() : Vec3(random.power_of_two(-4, 20) * random.direction());
  for (std::size_t i = 0; i < 4; ++i) q.from[i] = scale * (q.from[i] + shift), q.to[i] = scale * (q.to[i] + shift);
  return q;
}

constexpr std::array families{
    ImpactFamily{"anywhere", anywhere},
    ImpactFamily{"step", step},
    ImpactFamily{"resting", resting},
    ImpactFamily{"grid", on_grid},
    ImpactFamily{"short on grid", short_on_grid},
    ImpactFamily{"in a plane", in_plane},
    ImpactFamily{"doubled", doubled},
    ImpactFamily{"standing", standing},
    ImpactFamily{"touching at an end", touching_at_an_end},
    ImpactFamily{"without extent", without_extent},
    ImpactFamily{"parallel", parallel},
    ImpactFamily{"aligned", aligned},
    ImpactFamily{"turning", turning},
    ImpactFamily{"elsewhere", elsewhere},
};

}  // namespace

std::span<const ImpactFamily> impact_families() { return families; }

VertexImpact solve(const ImpactQuery& query, const ImpactOptions& options) {
  const auto &x = query.from, &y = query.to;
  if (query.edges) return edge_edge_impact({x[0], x[1]}, {x[2], x[3]}, {y[0], y[1]}, {y[2], y[3]}, options);
  return point_triangle_impact(x[0], {x[1], x[2], x[3]}, y[0], {y[1], y[2], y[3]}, options);
}

double longest_motion(const ImpactQuery& query) {
  double most = 0;
  const std::size_t first = query.edges ? 2 : 1;
  for (std::size_t i = 0; i < first; ++i)
    for (std::size_t j = first; j < 4; ++j)
      most = std::max(most, ((query.to[i] - query.to[j]) - (query.from[i] - query.from[j])).norm());
  return most;
}

}  // namespace tandem::reference
