// FCL's collision manager as a contestant of the bench of whole steps.
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include <algorithm>

#include "fcl_shape.h"
#include "scene_detector.h"

namespace tandem::bench {
namespace {

struct FclBody {
  std::uint32_t index;
  bool is_static;
};

const FclBody& body_of(const fcl::CollisionObjectd* object) {
  return *static_cast<const FclBody*>(object->getUserData());
}

/// A half-space as a square of two triangles about the origin, larger than any scene. FCL tests a half-space against
/// every triangle of a mesh; for two triangles it uses the mesh's hierarchy.
Shape wide_square(const Shape& half_space) {
  constexpr double wide = 1000;  // metres
  const Vec3 n = half_space.normal(), u = n.unitOrthogonal(), v = n.cross(u), middle = half_space.offset() * n;
  Mesh mesh;
  for (const Vec3& corner : {Vec3(-u - v), Vec3(u - v), Vec3(u + v), Vec3(v - u)})
    mesh.vertices.push_back(middle + wide * corner);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return Shape(std::move(mesh));
}

bool has_meshes(const Scene& scene) {
  const auto shapes = scene.shapes();
  return std::any_of(shapes.begin(), shapes.end(), [](const Shape& s) { return s.kind() == ShapeKind::mesh; });
}

/// All bounded bodies in one manager; pairs of two static ones are left out before their shapes are tested. The
/// manager's tree does not work with a half-space's infinite box: moving bodies are tested against half-spaces one by
/// one, by their boxes first.
class FclDetector final : public SceneDetector {
 public:
  FclDetector(const Scene& scene, std::string name, std::size_t most_contacts)
      : name_(std::move(name)), request_(most_contacts, true) {
    std::vector<std::shared_ptr<fcl::CollisionGeometryd>> shapes;
    const bool square = has_meshes(scene);
    for (const Shape& shape : scene.shapes())
      shapes.push_back(fcl_shape(square && !shape.is_bounded() ? wide_square(shape) : shape));
    bodies_.reserve(scene.indices());
    std::vector<fcl::CollisionObjectd*> all;
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      bodies_.push_back({i, scene.is_static()[i] != 0});
      objects_.push_back(std::make_unique<fcl::CollisionObjectd>(shapes[scene.shape_indices()[i]],
                                                                 fcl_pose(scene.poses()[i])));
      objects_.back()->setUserData(&bodies_.back());
      objects_.back()->computeAABB();
      if (const Shape& shape = scene.shape_of(i); shape.is_bounded()) {
        all.push_back(objects_.back().get());
      } else {
        const Pose& pose = scene.poses()[i];
        const Vec3 normal = pose.rotation * shape.normal();
        half_spaces_.push_back({&bodies_.back(), normal, shape.offset() + normal.dot(pose.translation)});
      }
    }
    manager_.registerObjects(all);
    manager_.setup();
  }

  std::string name() const override { return name_; }

  void detect(const Scene& scene) override {
    for (const FclBody& body : bodies_) {
      if (body.is_static) continue;
      objects_[body.index]->setTransform(fcl_pose(scene.poses()[body.index]));
      objects_[body.index]->computeAABB();
    }
    manager_.update();
    touching_.clear();
    contacts_.clear();
    manager_.collide(this, meet);
    for (const HalfSpaceBody& ground : half_spaces_)
      for (const FclBody& body : bodies_) {
        if (body.is_static) continue;
        const fcl::AABBd& box = objects_[body.index]->getAABB();
        const Vec3 deepest = (ground.normal.array() > 0).select(box.min_, box.max_);
        if (ground.normal.dot(deepest) <= ground.offset)
          collide(objects_[body.index].get(), body, objects_[ground.body->index].get(), *ground.body);
      }
  }

  std::vector<TouchingPair> found() const override {
    std::vector<TouchingPair> out;
    for (const Touching& pair : touching_) {
      double depth = 0;
      for (std::size_t i = 0; i < pair.contacts; ++i)
        depth = std::max(depth, contacts_[pair.first_contact + i].penetration_depth);
      out.push_back(
          {std::min(pair.a, pair.b), std::max(pair.a, pair.b), static_cast<std::uint32_t>(pair.contacts), depth});
    }
    return out;
  }

 private:
  struct Touching {
    std::uint32_t a, b;
    std::size_t first_contact, contacts;
  };

  struct HalfSpaceBody {
    const FclBody* body;
    Vec3 normal;  // world frame, like the offset
    double offset;
  };

  static bool meet(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self) {
    const FclBody &body_a = body_of(a), &body_b = body_of(b);
    if (!body_a.is_static || !body_b.is_static) static_cast<FclDetector*>(self)->collide(a, body_a, b, body_b);
    return false;  // continue
  }

  void collide(const fcl::CollisionObjectd* a, const FclBody& body_a, const fcl::CollisionObjectd* b,
               const FclBody& body_b) {
    fcl::CollisionResultd result;
    fcl::collide(a, b, request_, result);
    if (!result.isCollision()) return;
    touching_.push_back({body_a.index, body_b.index, contacts_.size(), result.numContacts()});
    for (std::size_t i = 0; i < result.numContacts(); ++i) contacts_.push_back(result.getContact(i));
  }

  std::string name_;
  fcl::CollisionRequestd request_;
  std::vector<FclBody> bodies_;
  std::vector<HalfSpaceBody> half_spaces_;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
  fcl::DynamicAABBTreeCollisionManagerd manager_;
  std::vector<Touching> touching_;
  std::vector<fcl::Contactd> contacts_;
};

}  // namespace

SceneDetectors fcl_detectors(const Scene& scene) {
  SceneDetectors out;
  out.push_back(std::make_unique<FclDetector>(scene, "FCL, 4 contacts", 4));
  if (has_meshes(scene)) out.push_back(std::make_unique<FclDetector>(scene, "FCL, all contacts", 1'000'000));
  return out;
}

}  // namespace tandem::bench
