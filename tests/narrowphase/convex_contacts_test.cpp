// Triangles so deep inside a convex shape that they need no solver: leaving them out changes no force, and the deepest
// contact is still found.
#include "meshes/contacts/convex_contacts.h"

#include <hwy/targets.h>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "catch.h"
#include "mesh_samples.h"
#include "meshes/contacts/normal_cone.h"
#include "one_instruction_set.h"
#include "random_pairs.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;

namespace {

// `unit`: all lengths are times that.
std::vector<Shape> large_shapes(double unit = 1) {
  Random random(4);
  Convex hull;
  for (int i = 0; i < 24; ++i) hull.vertices.push_back(unit * 0.6 * random.direction());
  return {Sphere{unit * 0.6},
          Box{unit * Vec3(0.7, 0.4, 0.5)},
          Capsule{unit * 0.4, unit * 0.6},
          Cylinder{unit * 0.5, unit * 0.9},
          Cone{unit * 0.6, unit * 1.1},
          Ellipsoid{unit * Vec3(0.7, 0.5, 0.4)},
          Shape(hull)};
}

}  // namespace

TEST_CASE("contacts with a convex shape: of triangles deep inside none that pushes is left out, nor the deepest") {
  Random random(3);
  std::size_t pushing = 0, inside = 0;
  for (const Shape& mesh : {Shape(torus(0.5, 0.25, 24, 16)), Shape(box_mesh({0.8, 0.7, 0.6}, 5))})
    for (const Shape& convex : large_shapes())
      for (int i = 0; i < 6; ++i) {
        Pose at{random.rotation(), random.vec(-0.5, 0.5)};
        if (i == 5) at.rotation.setIdentity();
        CAPTURE(name(convex.kind()), mesh.triangles().size(), i);
        const NarrowPhaseOptions options;
        const Pose home;
        const MeshConvexPair pair({mesh, home}, {convex, at}, options);
        const ConvexContacts contacts(pair, 0);
        PatchCollector all(pair.size(), {});
        PairAnswer near;
        near.signed_distance = std::numeric_limits<double>::infinity();
        std::vector<Contact> found;
        contacts.find(near, all, found);
        contacts.append_patches(all, std::numeric_limits<double>::infinity(), found);
        double deepest = std::numeric_limits<double>::infinity();
        for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
          const Corners p = pair.corners(t);
          const PairAnswer own = pair.solve(p, Request::distance);
          if (!(own.signed_distance < -1e-6)) continue;
          ++inside;
          deepest = std::min(deepest, own.signed_distance);
          const Vec3 outward = area_vector(p).normalized();
          if (outward.dot(own.normal) < 0.1 || own.normal.dot(pair.centre() - own.point_a) < 0) continue;
          if (!in_normal_cone(pair.model(), t, own.normal, pair.in_mesh(own.point_a), 1e-9)) continue;
          ++pushing;
          CHECK(std::any_of(found.begin(), found.end(), [&](const Contact& c) {
            return c.normal.dot(own.normal) > 0.95 && c.depth > -own.signed_distance - 1e-9;
          }));
        }
        if (std::isfinite(deepest)) CHECK(near.signed_distance == Approx(deepest).margin(1e-9));
      }
  CHECK(inside > 4000);
  CHECK(pushing > 50);
}

namespace {

// Is anything of the contacts along n (unit) over the triangle?
bool is_over(const MeshConvexPair& pair, const Corners& p, const Vec3& n) {
  const Vec3 low = pair.support(-n);
  const double depth = n.dot(p[0] - low);
  std::vector<Contact> contacts;
  pair.append_patch(p, {-depth, low + depth * n, low, n, 0}, contacts);
  const double turn = n.dot(area_vector(p)) > 0 ? 1 : -1;
  const auto is_beyond = [&](const Vec3& at) {
    for (std::size_t k = 0; k < 3; ++k)
      if (turn * (p[(k + 1) % 3] - p[k]).cross(n).dot(at - p[k]) > 0) return true;
    return false;
  };
  return std::any_of(contacts.begin(), contacts.end(),
                     [&](const Contact& c) { return c.feature != 0xffffffffu || !is_beyond(low); });
}

Mesh displaced(Mesh mesh) {
  for (Vec3& v : mesh.vertices) v += Vec3(3, -2, 5);
  return mesh;
}

// The results of the screening of all bottom nodes, lengths in the given unit.
std::vector<std::uint64_t> told(const MeshConvexPair& pair, double unit = 1) {
  const TriangleScreen screen = pair.screen();
  std::vector<std::uint64_t> out;
  ScreenedTriangles screened;
  pair.query().each_bottom(0, [&](const MeshNode& node, std::uint32_t within) {
    screen.look(node, within, screened);
    out.push_back(screened.deep & within), out.push_back(screened.beside & screened.deep & within);
    for (std::uint32_t lane = 0; lane < mesh_lanes; ++lane)
      if ((screened.deep & within) >> lane & 1)
        for (const double x : {screened.depth[lane] / unit, screened.chord[lane] / unit, screened.cosine_off[lane]})
          out.push_back(std::bit_cast<std::uint64_t>(x));
    return false;
  });
  return out;
}

}  // namespace

TEST_CASE("triangles screened at once: the same bits on each instruction set") {
  const auto all = [] {
    Random random(12);
    std::vector<std::uint64_t> out;
    for (const Shape& mesh : {Shape(displaced(torus(0.5, 0.25, 24, 16))), Shape(box_mesh({0.8, 0.0002, 0.7}, 6))})
      for (const Shape& convex : large_shapes())
        for (int i = 0; i < 4; ++i) {
          const Pose home;
          const Pose at{i == 3 ? Mat3(Mat3::Identity()) : random.rotation(),
                        random.vec(-0.4, 0.4) + mesh_of(mesh).centre};
          const NarrowPhaseOptions options;
          const std::vector<std::uint64_t> one = told(MeshConvexPair({mesh, home}, {convex, at}, options));
          out.insert(out.end(), one.begin(), one.end());
        }
    return out;
  };
  const std::vector<std::uint64_t> usual = all();
  CHECK(usual.size() > 10000);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    CAPTURE(std::string(hwy::TargetName(target)));
    const OneInstructionSet only(target);
    CHECK((all() == usual));
  }
}

TEST_CASE("triangles screened at once: the same bits in any unit of length") {
  const auto all = [](double unit) {
    Random random(12);
    std::vector<std::uint64_t> out;
    for (Mesh mesh : {displaced(torus(0.5, 0.25, 24, 16)), box_mesh({0.8, 0.0002, 0.7}, 6)}) {
      for (Vec3& v : mesh.vertices) v *= unit;
      const Shape shape(mesh);
      for (const Shape& convex : large_shapes(unit)) {
        const Pose at{random.rotation(), unit * random.vec(-0.4, 0.4) + mesh_of(shape).centre}, home;
        const NarrowPhaseOptions options;
        const std::vector<std::uint64_t> one = told(MeshConvexPair({shape, home}, {convex, at}, options), unit);
        out.insert(out.end(), one.begin(), one.end());
      }
    }
    return out;
  };
  const std::vector<std::uint64_t> usual = all(1);
  CHECK(usual.size() > 2000);
  for (const int exponent : {-84, -20, 20, 84}) {
    CAPTURE(exponent);
    CHECK((all(std::ldexp(1.0, exponent)) == usual));
  }
}

// A strip's normal may be off across it, and where it leans little to a cone's axis, the line that the cone shows
// turns by ten times as much.
TEST_CASE("triangles screened at once: beside a cone are those that are so along all normals that theirs may be") {
  const double height = 4e-6, lean = 0.101;
  const Shape strip(box_mesh({0.02, height, 0.001})), cone(Cone{1, 0.1});
  const Mat3 turn = Eigen::AngleAxisd(std::asin(lean), Vec3::UnitY()).toRotationMatrix();
  std::size_t deep = 0, beside = 0, over = 0;
  for (const double x : {0.7, 0.8, 0.9})
    for (double y = -0.15; y < 0.15; y += 0.0005) {
      const double level = -0.048;
      const Pose at{turn.transpose(), turn.transpose() * -Vec3(x, y, level)}, home;
      const NarrowPhaseOptions options;
      const MeshConvexPair pair({strip, home}, {cone, at}, options);
      const TriangleScreen screen = pair.screen();
      ScreenedTriangles screened;
      pair.query().each_bottom(0, [&](const MeshNode& node, std::uint32_t within) {
        screen.look(node, within, screened);
        for (std::uint32_t lane = 0; lane < mesh_lanes; ++lane) {
          if (((screened.deep & within) >> lane & 1) == 0) continue;
          const Corners p = pair.corners(pair.model().triangle_of(node, lane));
          const Vec3 normal = area_vector(p).normalized();
          if (normal[2] > -0.5) continue;  // the cone shows its base to the others, or nothing of its side
          ++deep;
          const bool is_beside = (screened.beside >> lane & 1) != 0;
          beside += is_beside;
          for (const double side : {-1.0, -0.5, 0.5, 1.0}) {
            const Vec3 n = (normal + side * screened.cosine_off[lane] * Vec3::UnitY()).normalized();
            const bool lies_over = is_over(pair, p, n);
            over += lies_over;
            CAPTURE(x, y, side, screened.cosine_off[lane], normal[0], normal[2]);
            CHECK_FALSE((is_beside && lies_over));
          }
        }
        return false;
      });
    }
  CAPTURE(deep, beside, over);
  CHECK(beside > 50);
  CHECK(over > 20);
}

TEST_CASE("triangles screened at once: depths, chords and what lies beside are as told") {
  Random random(8);
  std::size_t deep = 0, beside = 0;
  Mesh surface = torus(0.5, 0.25, 40, 24);
  surface.solid = false;
  const Shape slivers(box_mesh({0.8, 0.0002, 0.7}, 6)), crate(box_mesh({0.8, 0.6, 0.5}, 5));
  for (const Shape& mesh :
       {Shape(torus(0.5, 0.25, 40, 24)), Shape(surface), crate, slivers, Shape(displaced(torus(0.5, 0.25, 40, 24)))})
    for (const Shape& convex : large_shapes())
      for (int i = 0; i < 6; ++i) {
        // The last two are turned by nothing and by a quarter: faces tie.
        Pose at{random.rotation(), random.vec(-0.5, 0.5) + mesh_of(mesh).centre}, home;
        if (i == 4) at.rotation.setIdentity();
        if (i == 5) at.rotation << 0, -1, 0, 0, 0, -1, 1, 0, 0;
        const NarrowPhaseOptions options;
        const MeshConvexPair pair({mesh, home}, {convex, at}, options);
        const TriangleScreen screen = pair.screen();
        REQUIRE(screen.applies());
        ScreenedTriangles screened;
        const auto check = [&](const Corners& p, std::size_t lane) {
          const PairAnswer own = pair.solve(p, Request::distance);
          const double depth = screened.depth[lane];
          CHECK(own.signed_distance < 0);
          CHECK(-own.signed_distance <= depth);
          const Vec3 normal = area_vector(p).normalized(), across = normal.cross(random.direction()).normalized();
          CHECK(screened.chord[lane] <= normal.dot(pair.support(normal) - pair.support(-normal)) + 1e-9);
          const double cosine = depth / screened.chord[lane] + screened.cosine_off[lane];
          const Vec3 leaning = cosine * normal + std::sqrt(std::max(0.0, 1 - cosine * cosine)) * across;
          for (const double side : {1.0, -1.0}) {
            const Vec3 n = side * leaning;
            if (side > 0 || !mesh_of(mesh).solid)
              CHECK(std::max({n.dot(p[0]), n.dot(p[1]), n.dot(p[2])}) - n.dot(pair.support(-n)) >= depth * (1 - 1e-6));
          }
          if ((screened.beside >> lane & 1) == 0) return;
          ++beside;
          const bool as_wound = mesh_of(mesh).solid || normal.dot(pair.centre() - p[0]) > 0;
          CHECK_FALSE(is_over(pair, p, as_wound ? normal : Vec3(-normal)));
        };
        pair.query().each_bottom(0, [&](const MeshNode& node, std::uint32_t within) {
          screen.look(node, within, screened);
          for (std::uint32_t lane = 0; lane < mesh_lanes; ++lane)
            if ((screened.deep & within) >> lane & 1)
              ++deep, check(pair.corners(pair.model().triangle_of(node, lane)), lane);
          return false;
        });
      }
  CAPTURE(deep, beside);
  CHECK(deep > 10000);
  CHECK(beside > 5000);
}
