// Volume, centre of mass and inertia of a shape of density 1.
#pragma once
#include <span>

#include "shapes/hull.h"
#include "shapes/lazily.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// About the z axis, symmetric; the centre of mass lies at z.
MassProperties symmetric(double volume, double xx, double yy, double zz, double z = 0);
MassProperties box_mass(const Vec3& size);
MassProperties hull_mass(const Hull& hull);
MassProperties mesh_mass(const MeshModel& mesh);

Bounds bounds_of(std::span<const Vec3> vertices);

/// Of a shape, and what its copies have in common. A mesh's is made when first asked for.
class detail::ShapeMass {
 public:
  explicit ShapeMass(const MassProperties& mass) {
    mass_.get([&] { return mass; });
  }
  explicit ShapeMass(const MeshModel& mesh) : mesh_(&mesh) {}

  const MassProperties& get() const {
    return mass_.get([this] { return mesh_mass(*mesh_); });
  }

 private:
  const MeshModel* mesh_ = nullptr;  // held by the shapes; null: the mass was given
  Lazily<MassProperties> mass_;
};

}  // namespace tandem
