// Volume, centre of mass and inertia of a shape of density 1.
#pragma once
#include <span>

#include "shapes/hull.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

MassProperties mass_of(const Shape& shape);  ///< of its core, without rounding
MassProperties box_mass(const Vec3& size);
MassProperties hull_mass(const Hull& hull);
MassProperties mesh_mass(const MeshModel& mesh);

Bounds bounds_of(std::span<const Vec3> vertices);

}  // namespace tandem
