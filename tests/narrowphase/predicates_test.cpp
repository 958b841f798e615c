// Exact tests of intersecting triangles.
#include "triangles/predicates.h"

#include <boost/multiprecision/cpp_int.hpp>
#include <tuple>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "triangles/exact_number.h"

using namespace tandem;
using namespace tandem::test;

namespace {

using Rational = boost::multiprecision::cpp_rational;
using Corners = std::array<Vec3, 3>;
using Exact = std::array<Rational, 3>;

// An independent reference: two triangles intersect if and only if no direction separates them strictly, and it
// suffices to try the normals of both, the cross products of their edges, and for coplanar or degenerate triangles the
// normals to edges in their plane and the edges themselves.
Exact sub(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Rational dot(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

std::array<Exact, 3> place(const Corners& t, const Pose& pose) {
  std::array<Exact, 3> out;
  for (std::size_t c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i) {
      Rational x(pose.translation[i]);
      for (int j = 0; j < 3; ++j) x += Rational(pose.rotation(i, j)) * Rational(t[c][j]);
      out[c][static_cast<std::size_t>(i)] = x;
    }
  return out;
}

bool oracle(const Corners& ta, const Pose& pa, const Corners& tb, const Pose& pb) {
  const auto a = place(ta, pa), b = place(tb, pb);
  std::vector<Exact> edges, directions;
  for (const auto* t : {&a, &b})
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(sub((*t)[(k + 1) % 3], (*t)[k]));
  for (const auto& p : a)
    for (const auto& q : b) edges.push_back(sub(p, q));
  for (const auto& e : edges) directions.push_back(e);
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) directions.push_back(cross(edges[i], edges[j]));
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < edges.size(); ++j) directions.push_back(cross(edges[i], cross(edges[i], edges[j])));
  for (const auto& d : directions) {
    Rational lo_a = dot(d, a[0]), hi_a = lo_a, lo_b = dot(d, b[0]), hi_b = lo_b;
    for (std::size_t k = 1; k < 3; ++k) {
      lo_a = std::min<Rational>(lo_a, dot(d, a[k])), hi_a = std::max<Rational>(hi_a, dot(d, a[k]));
      lo_b = std::min<Rational>(lo_b, dot(d, b[k])), hi_b = std::max<Rational>(hi_b, dot(d, b[k]));
    }
    if (hi_a < lo_b || hi_b < lo_a) return false;
  }
  return true;
}

bool fast(const Corners& a, const Pose& pa, const Corners& b, const Pose& pb, double reach) {
  TriangleTest test(pa, pb, reach);
  return test(a, b, {test.in_a(b[0]), test.in_a(b[1]), test.in_a(b[2])});
}

}  // namespace

TEST_CASE("triangles on a small grid, where touching, coplanar and zero-area are common, agree with rationals") {
  std::mt19937_64 random(11);
  std::uniform_int_distribution<int> cells(-1, 1);
  const auto cell = [&]() -> double { return cells(random); };
  int hits = 0, flat = 0;
  for (int i = 0; i < 800; ++i) {
    Corners a, b;
    for (Corners* t : {&a, &b})
      for (Vec3& v : *t) v = Vec3{cell(), cell(), i % 3 == 0 ? 0 : cell()};
    const Pose pose;
    const bool want = oracle(a, pose, b, pose);
    hits += want;
    flat += (a[1] - a[0]).cross(a[2] - a[0]).isZero();
    CAPTURE(i);
    REQUIRE(fast(a, pose, b, pose, 1) == want);
    REQUIRE(fast(b, pose, a, pose, 1) == want);
  }
  CHECK(hits > 200);
  CHECK(hits < 780);
  CHECK(flat > 40);
}

TEST_CASE("triangles in random poses, a rounding apart from touching, agree with rationals") {
  std::mt19937_64 random(12);
  int hits = 0;
  for (int i = 0; i < 80; ++i) {
    Corners a, b;
    for (Vec3& v : a) v = random_point(random, 1);
    for (Vec3& v : b) v = random_point(random, 1);
    const double far = i % 2 ? 0 : 1e6;
    Pose pa = random_pose(random, 1), pb = random_pose(random, 1);
    for (Pose* pose : {&pa, &pb}) pose->translation += Vec3::Constant(far);
    // Moves a vertex of B onto a point of A, as nearly as doubles can.
    const Vec3 target = pa * (0.2 * a[0] + 0.3 * a[1] + 0.5 * a[2]);
    pb.translation += target - pb * b[static_cast<std::size_t>(i) % 3];
    const bool want = oracle(a, pa, b, pb);
    hits += want;
    CAPTURE(i);
    REQUIRE(fast(a, pa, b, pb, 1) == want);
    REQUIRE(fast(b, pb, a, pa, 1) == want);
  }
  CHECK(hits > 8);
  CHECK(hits < 80);
}

TEST_CASE("triangles with coordinates beyond the range of expansions are still decided exactly") {
  const Corners a{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const Pose pose;
  for (const double tiny : {1e-60, 1e-99}) {
    const Corners above{Vec3(0.2, 0.2, tiny), Vec3(0.3, 0.2, 1), Vec3(0.2, 0.3, 1)};
    const Corners through{Vec3(0.2, 0.2, -tiny), Vec3(0.3, 0.2, 1), Vec3(0.2, 0.3, 1)};
    CHECK_FALSE(fast(a, pose, above, pose, 1));
    CHECK(fast(a, pose, through, pose, 1));
  }
}

TEST_CASE("triangles in one plane, with common corners, needles and far out: filtered, exact and rationals agree") {
  std::mt19937_64 random(14);
  std::uniform_int_distribution<int> cells(-2, 2);
  const auto cell = [&]() -> double { return cells(random); };
  int hits = 0;
  for (int i = 0; i < 6000; ++i) {
    Corners a, b;
    const double stretch = i % 4 == 1 ? 1e4 : 1, size = i % 5 == 2 ? 1e-4 : 1;
    for (Vec3& v : a) v = Vec3{stretch * cell(), cell(), i % 7 == 3 ? cell() : 0} / 3;
    for (Vec3& v : b) v = size * Vec3{stretch * cell(), cell(), i % 7 == 3 ? cell() : 0} / 3;
    if (i % 3 == 0) b[0] = a[1];
    Pose pa, pb;
    if (i % 2) pa = random_pose(random, i % 8 == 1 ? 1e6 : 1);
    pb = pa;
    // Along the plane, as nearly as doubles can.
    if (i % 6 == 1) pb.translation += pb.rotation * Vec3{stretch * cell(), cell(), 0} / 3;
    if (i % 12 == 7) pb.rotation *= Eigen::AngleAxisd(0.5, Vec3::UnitZ()).toRotationMatrix();
    const bool want = TriangleTest(pa, pb, 1e4).exact(a, b);
    hits += want;
    CAPTURE(i);
    if (i % 80 < 2) REQUIRE(oracle(a, pa, b, pb) == want);
    REQUIRE(fast(a, pa, b, pb, 2 * stretch) == want);
    REQUIRE(fast(b, pb, a, pa, 2 * stretch) == want);
  }
  CHECK(hits > 1500);
  CHECK(hits < 5000);
}

TEST_CASE("wide integers add, subtract and multiply as integers without a limit do") {
  using boost::multiprecision::cpp_int;
  std::mt19937_64 random(13);
  const auto value = [](const auto& x, std::size_t limbs) {
    cpp_int r = 0;
    for (std::size_t i = limbs; i-- > 0;) r = (r << 64) + x.limb(i);
    return x.sign() < 0 ? cpp_int(r - (cpp_int(1) << (64 * limbs))) : r;
  };
  for (int i = 0; i < 2000; ++i) {
    const auto draw = [&](unsigned most) {
      const Uint128 high = random(), low = random();
      const Uint128 magnitude = (high << 64 | low) >> (random() % 127 + 1);
      return std::tuple{magnitude, static_cast<unsigned>(random() % (most + 1)), random() % 2 == 0};
    };
    const auto exact = [](const auto& t) {
      const cpp_int x = cpp_int(std::get<0>(t)) << std::get<1>(t);
      return std::get<2>(t) ? cpp_int(-x) : x;
    };
    const auto tx = draw(120), ty = draw(120), tz = draw(0);
    WideInt<4> x, y;
    WideInt<2> z;
    std::apply([&](auto... t) { x.add(t...); }, tx);
    std::apply([&](auto... t) { y.add(t...); }, ty);
    std::apply([&](auto... t) { z.add(t...); }, tz);
    CAPTURE(i);
    REQUIRE(value(x, 4) == exact(tx));
    REQUIRE(value(x + y, 4) == exact(tx) + exact(ty));
    REQUIRE(value(x - y, 4) == exact(tx) - exact(ty));
    REQUIRE(value(x * y, 8) == exact(tx) * exact(ty));
    REQUIRE(value(x * z, 6) == exact(tx) * exact(tz));
    REQUIRE(value(z * y, 6) == exact(tz) * exact(ty));
    REQUIRE((x - y).sign() == (exact(tx) - exact(ty)).sign());
  }
  for (const double d : {0.0, 1.0, -0.75, 3e300, 5e-324, -2.5e-310, 0.1}) {
    const Dyadic r(d);
    CHECK(std::ldexp(static_cast<double>(r.mantissa), r.exponent) * (r.negative ? -1 : 1) == d);
  }
}
