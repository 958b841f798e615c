// tandem::fcl::collide and distance compared with FCL's on every kind of geometry, and the conversions they use.
#include "tandem/fcl/pair_queries.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/geometric_shape_to_BVH_model.h>
#include <fcl/geometry/octree/octree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/plane.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/geometry/shape/triangle_p.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <random>
#include <set>

#include "catch.h"

namespace {

using GeometryPointer = std::shared_ptr<::fcl::CollisionGeometryd>;
using FclObject = ::fcl::CollisionObjectd;
using tandem::ShapeKind;
using tandem::fcl::to_shape;

template <class Volume>
GeometryPointer mesh_of(const ::fcl::Boxd& box) {
  auto model = std::make_shared<::fcl::BVHModel<Volume>>();
  ::fcl::generateBVHModel(*model, box, ::fcl::Transform3d::Identity());
  return model;
}

GeometryPointer octahedron() {
  using V = ::fcl::Vector3d;
  auto vertices = std::make_shared<std::vector<V>>(
      std::vector<V>{V(1, 0, 0), V(-1, 0, 0), V(0, 1, 0), V(0, -1, 0), V(0, 0, 1), V(0, 0, -1)});
  auto faces = std::make_shared<std::vector<int>>(
      std::vector<int>{3, 0, 2, 4, 3, 2, 1, 4, 3, 1, 3, 4, 3, 3, 0, 4, 3, 2, 0, 5, 3, 1, 2, 5, 3, 3, 1, 5, 3, 0, 3, 5});
  return std::make_shared<::fcl::Convexd>(vertices, 8, faces);
}

std::vector<GeometryPointer> convex_kinds() {
  return {std::make_shared<::fcl::Sphered>(0.7),
          std::make_shared<::fcl::Boxd>(1, 1.4, 0.8),
          std::make_shared<::fcl::Capsuled>(0.4, 1.1),
          std::make_shared<::fcl::Cylinderd>(0.6, 1.2),
          std::make_shared<::fcl::Coned>(0.7, 1.3),
          std::make_shared<::fcl::Ellipsoidd>(0.5, 0.7, 0.9),
          octahedron()};
}

::fcl::Transform3d random_pose(std::mt19937& random, double reach) {
  std::uniform_real_distribution<double> number(-1, 1);
  ::fcl::Transform3d pose = ::fcl::Transform3d::Identity();
  ::fcl::Quaterniond q{number(random), number(random), number(random), number(random)};
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = reach * ::fcl::Vector3d{number(random), number(random), number(random)};
  return pose;
}

}  // namespace

TEST_CASE("FCL's geometries as shapes") {
  const auto kind = [](const GeometryPointer& geometry) { return to_shape(*geometry)->kind(); };
  CHECK(to_shape<double>(::fcl::Sphered(0.5))->radius() == 0.5);
  CHECK(to_shape<double>(::fcl::Boxd(1, 2, 3))->half_size() == tandem::Vec3(0.5, 1, 1.5));
  const auto cone = to_shape<double>(::fcl::Coned(0.5, 2));
  CHECK(cone->kind() == ShapeKind::cone);
  CHECK(cone->length() == 2);
  const auto half = to_shape<double>(::fcl::Halfspaced(::fcl::Vector3d(0, 0, 1), 3));
  CHECK(half->kind() == ShapeKind::halfspace);
  CHECK(half->offset() == 3);
  CHECK(to_shape<float>(::fcl::Ellipsoidf(1, 2, 3))->radii() == tandem::Vec3(1, 2, 3));
  using V = ::fcl::Vector3d;
  CHECK(to_shape<double>(::fcl::TrianglePd(V(0, 0, 0), V(1, 0, 0), V(0, 1, 0)))->vertices()[1] == V(1, 0, 0));
  CHECK(kind(octahedron()) == ShapeKind::convex);

  const ::fcl::Boxd box(1, 2, 3);
  for (const GeometryPointer& mesh :
       {mesh_of<::fcl::AABBd>(box), mesh_of<::fcl::OBBd>(box), mesh_of<::fcl::RSSd>(box), mesh_of<::fcl::kIOSd>(box),
        mesh_of<::fcl::OBBRSSd>(box), mesh_of<::fcl::KDOP<double, 16>>(box), mesh_of<::fcl::KDOP<double, 18>>(box),
        mesh_of<::fcl::KDOP<double, 24>>(box)}) {
    const auto shape = to_shape(*mesh);
    REQUIRE(shape);
    CHECK(shape->kind() == ShapeKind::mesh);
    CHECK(shape->triangles().size() == 12);
    CHECK_FALSE(shape->is_solid());
    CHECK(shape->bounds({}).hi == tandem::Vec3(0.5, 1, 1.5));
  }
  const auto plane = to_shape<double>(::fcl::Planed(V(0, 0, 1), 3));
  CHECK(plane->kind() == ShapeKind::plane);
  CHECK(plane->offset() == 3);
  ::fcl::BVHModel<::fcl::OBBRSSd> points;
  points.beginModel();
  points.addSubModel(std::vector<V>{V(0, 0, 0), V(1, 0, 0)});
  points.endModel();
  CHECK_FALSE(to_shape<double>(points));

  ::fcl::Transform3d scales = ::fcl::Transform3d::Identity();
  scales.linear() *= 2;
  CHECK_THROWS_AS(tandem::fcl::to_pose<double>(scales), std::invalid_argument);
}

TEST_CASE("pairs of convex kinds collide and are as far apart as FCL says") {
  std::mt19937 random(1);
  int collided = 0, apart = 0;
  for (const GeometryPointer& a : convex_kinds())
    for (const GeometryPointer& b : convex_kinds())
      for (int pose = 0; pose < 12; ++pose) {
        const FclObject o1(a, random_pose(random, 1.1)), o2(b, random_pose(random, 1.1));
        CAPTURE(a->getNodeType(), b->getNodeType(), pose);
        // FCL's depth search aborts on some of these pairs: only distances are requested.
        ::fcl::DistanceResultd theirs, ours;
        ::fcl::DistanceRequestd wanted(true, false);
        wanted.distance_tolerance = 1e-9;
        ::fcl::distance(&o1, &o2, wanted, theirs);
        wanted.enable_signed_distance = true;
        const double told = tandem::fcl::distance(&o1, &o2, wanted, ours);
        CHECK(told == ours.min_distance);
        if (std::abs(ours.min_distance) > 1e-3) {
          CHECK((ours.min_distance > 0) == (theirs.min_distance > 0));
        }
        if (ours.min_distance > 0) {
          CHECK(ours.min_distance == Approx(theirs.min_distance).margin(2e-3));
        }
        CHECK((ours.nearest_points[0] - ours.nearest_points[1]).norm() ==
              Approx(std::abs(ours.min_distance)).margin(1e-9));
        CHECK(ours.o1 == a.get());
        CHECK(ours.o2 == b.get());
        ::fcl::DistanceResultd unsigned_one;
        wanted.enable_signed_distance = false;
        tandem::fcl::distance(a.get(), o1.getTransform(), b.get(), o2.getTransform(), wanted, unsigned_one);
        CHECK(unsigned_one.min_distance == (ours.min_distance < 0 ? -1 : ours.min_distance));

        ::fcl::CollisionRequestd request(8, true);
        ::fcl::CollisionResultd contacts, fcl_contacts, verdict;
        const std::size_t count = tandem::fcl::collide(&o1, &o2, request, contacts);
        CHECK(count == contacts.numContacts());
        CHECK(contacts.isCollision() == (ours.min_distance <= 0));
        request.enable_contact = false;
        CHECK(tandem::fcl::collide(&o1, &o2, request, verdict) == (contacts.isCollision() ? 1 : 0));
        if (std::abs(ours.min_distance) > 1e-3) {
          CHECK(::fcl::collide(&o1, &o2, request, fcl_contacts) == verdict.numContacts());
        }
        ++(contacts.isCollision() ? collided : apart);
        double deepest = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const auto& c = contacts.getContact(i);
          CHECK(c.normal.norm() == Approx(1));
          CHECK(c.o1 == a.get());
          deepest = std::max(deepest, c.penetration_depth);
        }
        if (contacts.isCollision()) {
          CHECK(deepest == Approx(-ours.min_distance).margin(1e-6));
        }
      }
  CHECK(collided > 100);
  CHECK(apart > 100);
}

TEST_CASE("FCL's normals and depths: from the first to the second, of a ball on a box and on a half-space") {
  ::fcl::Transform3d up = ::fcl::Transform3d::Identity();
  up.translation().z() = 0.9;
  const FclObject ball(std::make_shared<::fcl::Sphered>(0.5), up), box(std::make_shared<::fcl::Boxd>(1, 1, 1));
  const FclObject half(std::make_shared<::fcl::Halfspaced>(::fcl::Vector3d(0, 0, 1), 0.5));
  for (const FclObject* other : {&box, &half})
    for (const bool turned : {false, true}) {
      const FclObject *a = turned ? other : &ball, *b = turned ? &ball : other;
      const ::fcl::CollisionRequestd request(1, true);
      ::fcl::CollisionResultd ours, theirs;
      REQUIRE(tandem::fcl::collide(a, b, request, ours) == 1);
      REQUIRE(::fcl::collide(a, b, request, theirs) == 1);
      const auto &c = ours.getContact(0), &d = theirs.getContact(0);
      CHECK((c.normal - d.normal).norm() < 1e-6);
      CHECK((c.pos - d.pos).norm() < 1e-6);
      CHECK(c.penetration_depth == Approx(d.penetration_depth));
      CHECK(c.b1 == -1);
    }
}

TEST_CASE("contacts and distances name the triangles of meshes, as FCL's do") {
  ::fcl::Transform3d at = ::fcl::Transform3d::Identity();
  const FclObject mesh(mesh_of<::fcl::OBBRSSd>(::fcl::Boxd(1, 1.4, 0.8)));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-0.3, 0.3);
  for (int i = 0; i < 40; ++i) {
    at.translation() = ::fcl::Vector3d{number(random), number(random), 0.4 + 0.49};
    const FclObject ball(std::make_shared<::fcl::Sphered>(0.5), at);
    const ::fcl::CollisionRequestd request(4, true);
    ::fcl::CollisionResultd ours, theirs;
    REQUIRE(tandem::fcl::collide(&mesh, &ball, request, ours) == 1);
    ::fcl::collide(&mesh, &ball, request, theirs);
    std::set<std::intptr_t> named;
    for (std::size_t j = 0; j < theirs.numContacts(); ++j) named.insert(theirs.getContact(j).b1);
    CHECK(named.count(ours.getContact(0).b1) == 1);
    CHECK(ours.getContact(0).b2 == -1);

    at.translation().z() = 1.5;
    const FclObject above(std::make_shared<::fcl::Sphered>(0.5), at);
    ::fcl::DistanceRequestd nearest(true);
    ::fcl::DistanceResultd near, far;
    tandem::fcl::distance(&mesh, &above, nearest, near);
    ::fcl::distance(&mesh, &above, nearest, far);
    CHECK(near.b1 == far.b1);
    CHECK(near.b2 == -1);
  }
}

TEST_CASE("limits on contacts, better results and what is not occupied are honoured as by FCL") {
  const auto box = std::make_shared<::fcl::Boxd>(1, 1, 1);
  ::fcl::Transform3d lower = ::fcl::Transform3d::Identity();
  lower.translation().z() = -0.98;
  const FclObject a(box), b(box, lower);
  ::fcl::CollisionRequestd request(3, true);
  ::fcl::CollisionResultd result;
  CHECK(tandem::fcl::collide(&a, &b, request, result) == 3);
  CHECK(tandem::fcl::collide(&a, &b, request, result) == 3);  // the limit is reached
  request.num_max_contacts = 5;
  CHECK(tandem::fcl::collide(&a, &b, request, result) == 5);  // existing contacts count
  request.num_max_contacts = 0;
  ::fcl::CollisionResultd none;
  CHECK(tandem::fcl::collide(&a, &b, request, none) == 0);

  ::fcl::DistanceResultd near;
  near.min_distance = 0.25;
  lower.translation().z() = -3;
  const FclObject far(box, lower);
  CHECK(tandem::fcl::distance(&a, &far, ::fcl::DistanceRequestd(true), near) == 0.25);
  CHECK(near.o1 == nullptr);
  near.min_distance = 5;
  CHECK(tandem::fcl::distance(&a, &far, ::fcl::DistanceRequestd(true), near) == 2);
  CHECK(near.o1 == box.get());
  near.min_distance = 0;
  CHECK(tandem::fcl::distance(&a, &b, ::fcl::DistanceRequestd(true, true), near) == 0);

  const auto free_box = std::make_shared<::fcl::Boxd>(1, 1, 1);
  free_box->cost_density = 0;
  const FclObject ghost(free_box);
  ::fcl::CollisionResultd ours, theirs;
  request = ::fcl::CollisionRequestd(1, true);
  CHECK(tandem::fcl::collide(&a, &ghost, request, ours) == ::fcl::collide(&a, &ghost, request, theirs));
  request.enable_cost = true;
  CHECK(tandem::fcl::collide(&a, &b, request, ours) == 1);
  CHECK(ours.numCostSources() == 1);
}

TEST_CASE("meshes: FCL's verdicts, distances and pairs of triangles") {
  std::mt19937 random(2);
  tandem::fcl::ShapeCache shapes;
  const GeometryPointer mesh = mesh_of<::fcl::OBBRSSd>({1, 1.4, 0.8}), other = mesh_of<::fcl::RSSd>({0.9, 0.9, 0.9});
  const GeometryPointer same = mesh_of<::fcl::OBBRSSd>({0.9, 0.9, 0.9}), ball = std::make_shared<::fcl::Sphered>(0.5);
  int collided = 0;
  for (int pose = 0; pose < 60; ++pose) {
    CAPTURE(pose);
    const auto tf1 = random_pose(random, 0.7), tf2 = random_pose(random, 0.7);
    const FclObject o1(mesh, tf1), o2(same, tf2), o3(ball, tf2), o4(other, tf2);
    for (const FclObject* b : {&o2, &o3}) {
      ::fcl::CollisionRequestd request(1000, false);
      ::fcl::CollisionResultd ours, theirs;
      tandem::fcl::collide(&o1, b, request, ours, &shapes);
      ::fcl::collide(&o1, b, request, theirs);
      REQUIRE(ours.isCollision() == theirs.isCollision());
      collided += ours.isCollision() ? 1 : 0;
      if (b == &o2) {
        const auto triangles = [](const ::fcl::CollisionResultd& result) {
          std::set<std::pair<std::intptr_t, std::intptr_t>> all;
          for (std::size_t i = 0; i < result.numContacts(); ++i)
            all.insert({result.getContact(i).b1, result.getContact(i).b2});
          return all;
        };
        CHECK(triangles(ours) == triangles(theirs));
      }
      ::fcl::DistanceResultd near, theirs_near;
      tandem::fcl::distance(&o1, b, ::fcl::DistanceRequestd(true), near, &shapes);
      if (ours.isCollision()) {
        CHECK(near.min_distance == -1);
      } else {
        ::fcl::distance(&o1, b, ::fcl::DistanceRequestd(true), theirs_near);
        CHECK(near.min_distance == Approx(theirs_near.min_distance).margin(1e-3));
      }
      request = ::fcl::CollisionRequestd(4, true);
      ::fcl::CollisionResultd contacts;
      CHECK((tandem::fcl::collide(&o1, b, request, contacts) > 0) == ours.isCollision());
    }
    ::fcl::CollisionResultd one, another;  // of another hierarchy, which FCL refuses
    tandem::fcl::collide(&o1, &o4, ::fcl::CollisionRequestd(), one, &shapes);
    tandem::fcl::collide(&o1, &o2, ::fcl::CollisionRequestd(), another, &shapes);
    CHECK(one.isCollision() == another.isCollision());
  }
  CHECK(collided > 20);
  CHECK(collided < 110);
  CHECK(shapes.size() == 3);
}

TEST_CASE("the cache keeps what lives and knows another geometry at the same address") {
  tandem::fcl::ShapeCache shapes;
  const std::shared_ptr<const ::fcl::CollisionGeometryd> kept = octahedron();
  const tandem::Shape* first = shapes.shape_of(kept);
  REQUIRE(first != nullptr);
  CHECK(shapes.shape_of(kept) == first);
  // One buffer, two geometries one after the other.
  alignas(::fcl::Sphered) unsigned char place[sizeof(::fcl::Sphered)];
  for (const double radius : {1.0, 2.0}) {
    const std::shared_ptr<const ::fcl::CollisionGeometryd> ball(new (place)::fcl::Sphered(radius),
                                                                [](auto* sphere) { std::destroy_at(sphere); });
    CHECK(shapes.shape_of(ball)->radius() == radius);
  }
  for (int i = 0; i < 500; ++i) shapes.shape_of(std::shared_ptr<const ::fcl::CollisionGeometryd>(octahedron()));
  CHECK(shapes.size() < 200);
  CHECK(shapes.shape_of(kept) == first);
  shapes.forget(kept.get());
  const auto cells = std::make_shared<octomap::OcTree>(0.1);
  CHECK(shapes.shape_of<double>(std::make_shared<::fcl::OcTreed>(cells)) == nullptr);
}

TEST_CASE("a plane has two sides as FCL's has: its verdicts, depths and normals with convex shapes") {
  const FclObject plane(std::make_shared<::fcl::Planed>(::fcl::Vector3d(0, 0, 1), 0.2));
  const std::vector<GeometryPointer> bodies = {
      std::make_shared<::fcl::Sphered>(0.3), std::make_shared<::fcl::Boxd>(0.4, 0.3, 0.5),
      std::make_shared<::fcl::Capsuled>(0.2, 0.4), std::make_shared<::fcl::Cylinderd>(0.2, 0.4)};
  std::mt19937 random(5);
  int collided = 0, apart = 0;
  for (const GeometryPointer& body : bodies)
    for (int pose = 0; pose < 50; ++pose) {
      const FclObject o(body, random_pose(random, 0.8));
      ::fcl::CollisionResultd ours, theirs;
      const ::fcl::CollisionRequestd request(1, true);
      tandem::fcl::collide(&plane, &o, request, ours), ::fcl::collide(&plane, &o, request, theirs);
      REQUIRE(ours.isCollision() == theirs.isCollision());
      ::fcl::DistanceResultd gap;
      const double d = tandem::fcl::distance(&plane, &o, ::fcl::DistanceRequestd(true, true), gap);
      CHECK((d <= 0) == ours.isCollision());
      ++(ours.isCollision() ? collided : apart);
      if (!ours.isCollision()) continue;
      const auto &a = ours.getContact(0), &b = theirs.getContact(0);
      CHECK(a.penetration_depth == Approx(b.penetration_depth).margin(1e-9));
      CHECK((a.normal - b.normal).norm() < 1e-9);
      CHECK(d == Approx(-b.penetration_depth).margin(1e-9));
    }
  CHECK(collided > 30);
  CHECK(apart > 30);
}

TEST_CASE("octrees are answered by FCL") {
  auto tree = std::make_shared<octomap::OcTree>(0.1);
  for (double x = -0.5; x < 0.5; x += 0.05)
    for (double y = -0.5; y < 0.5; y += 0.05) tree->updateNode(octomap::point3d(float(x), float(y), 0), true);
  const auto octree = std::make_shared<::fcl::OcTreed>(tree);
  std::mt19937 random(4);
  int collided = 0;
  for (int pose = 0; pose < 50; ++pose) {
    const FclObject box(std::make_shared<::fcl::Boxd>(0.4, 0.3, 0.5), random_pose(random, 0.8));
    const FclObject o(octree);
    ::fcl::CollisionResultd our_contacts, their_contacts;
    const ::fcl::CollisionRequestd touches(3, true);
    CHECK(tandem::fcl::collide(&o, &box, touches, our_contacts) == ::fcl::collide(&o, &box, touches, their_contacts));
    collided += our_contacts.isCollision() ? 1 : 0;
    ::fcl::DistanceResultd ours, theirs;
    const ::fcl::DistanceRequestd request(true);
    CHECK(tandem::fcl::distance(&o, &box, request, ours) == ::fcl::distance(&o, &box, request, theirs));
  }
  CHECK(collided > 5);
}

TEST_CASE("pairs in float") {
  ::fcl::Transform3f aside = ::fcl::Transform3f::Identity();
  aside.translation().x() = 1.5f;
  const ::fcl::CollisionObjectf a(std::make_shared<::fcl::Boxf>(1, 1, 1)),
      b(std::make_shared<::fcl::Spheref>(0.5f), aside);
  ::fcl::DistanceResultf near;
  CHECK(tandem::fcl::distance(&a, &b, ::fcl::DistanceRequestf(true), near) == 0.5f);
  CHECK(near.nearest_points[0].x() == 0.5f);
  const ::fcl::CollisionObjectf plane(std::make_shared<::fcl::Planef>(::fcl::Vector3f(1, 0, 0), 0.1f));
  ::fcl::CollisionResultf result;
  CHECK(tandem::fcl::collide(&a, &plane, ::fcl::CollisionRequestf(1, true), result) > 0);
}
