#include "tandem/engine/builtin_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh_generators.h"
#include "random.h"

namespace tandem {
namespace {

constexpr std::size_t most_bodies = 1'000'000;

constexpr std::array<BuiltinScene, 8> table{{
    {"screws-in-bowl", "threaded bolts and nuts, solid meshes, falling into a bowl", 500},
    {"tori-on-cones", "tori of 1152 triangles falling on a field of cones", 2000},
    {"cubes-on-plane", "boxes falling on a plane", 3000},
    {"spheres-on-plane", "spheres falling on a plane", 2500},
    {"tori-on-plane", "tori of 1152 triangles falling on a plane", 1000},
    {"tori-and-cubes", "one torus to two boxes falling on a plane: pairs of very unequal cost", 1500},
    {"falling-apart", "spheres and boxes in free fall that never meet", 20000},
    {"complex-in-contact", "finely tessellated tori stacked so that all touch from the first step", 8},
}};

/// Bodies that are dropped: what they share, and how much room one needs.
struct Kind {
  ShapeId shape;
  double radius;  ///< of a ball about the shape's origin that holds it
};

double radius_of(const Mesh& mesh) {
  double squared = 0;
  for (const Vec3& vertex : mesh.vertices) squared = std::max(squared, vertex.squaredNorm());
  return std::sqrt(squared);
}

Kind add_mesh(Scene& scene, Mesh mesh, std::string shape_name) {
  const double radius = radius_of(mesh);
  return {scene.add_shape(Shape(std::move(mesh)), std::move(shape_name)), radius};
}

Kind add_torus(Scene& scene) { return add_mesh(scene, make_torus(0.6, 0.25, 24, 24), "torus"); }

Kind add_cube(Scene& scene) {
  const Vec3 size = Vec3::Constant(1);
  return {scene.add_shape(Shape(Box{size}), "cube"), size.norm() / 2};
}

Kind add_sphere(Scene& scene) { return {scene.add_shape(Shape(Sphere{0.5}), "sphere"), 0.5}; }

void add_fixed(Scene& scene, ShapeId shape, const Pose& pose = {}) {
  BodyOptions body;
  body.shape = shape;
  body.pose = pose;
  body.is_static = true;
  scene.add_body(body);
}

void add_ground(Scene& scene) { add_fixed(scene, scene.add_shape(Shape(HalfSpace{Vec3::UnitZ(), 0}), "ground")); }

/// Square cells in level layers, filled from below, centred on the z axis.
struct Layers {
  double spacing;      ///< between cells, sideways and upwards
  std::size_t layers;  ///< as many as this, then wider
  double bottom;       ///< height of the lowest cells' lower side

  std::size_t side(std::size_t bodies) const {
    auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(bodies) / static_cast<double>(layers)));
    while (side * side * layers < bodies) ++side;
    return side;
  }
  /// The middle of the k-th cell of those for `bodies`.
  Vec3 cell(std::size_t k, std::size_t bodies) const {
    const std::size_t across = side(bodies);
    const double half = static_cast<double>(across - 1) / 2;
    return {(static_cast<double>(k % across) - half) * spacing,
            (static_cast<double>(k / across % across) - half) * spacing,
            bottom + (static_cast<double>(k / (across * across)) + 0.5) * spacing};
  }
};

BodyOptions tumbled(const Kind& kind, const Vec3& cell_middle, double spacing, Random& random) {
  const double room = std::max(0.0, 0.98 * (spacing / 2 - kind.radius));
  BodyOptions body;
  body.shape = kind.shape;
  body.pose.rotation = random.rotation();
  for (int axis = 0; axis < 3; ++axis) body.pose.translation[axis] = cell_middle[axis] + random.uniform(-room, room);
  return body;
}

/// Distance of cells in diameters of the largest body: what is more than 1 is room for jitter.
double spacing_for(std::initializer_list<Kind> kinds, double loose = 1.04) {
  double radius = 0;
  for (const Kind& kind : kinds) radius = std::max(radius, kind.radius);
  return loose * 2 * radius;
}

Scene screws_in_bowl(std::size_t bodies, Random& random) {
  Scene scene;
  const Thread outer{.root_radius = 0.25, .crest_radius = 0.30, .pitch = 0.2, .turns = 4};
  const Thread inner{.root_radius = 0.37, .crest_radius = 0.32, .pitch = 0.2, .turns = 3};
  const Kind bolt =
      add_mesh(scene, make_bolt({.thread = outer, .head_radius = 0.5, .head_height = 0.35, .segments = 12}), "bolt");
  const Kind nut = add_mesh(scene, make_nut({.thread = inner, .corner_radius = 0.6, .segments = 12}), "nut");

  // Level layers would leave those over the middle far to fall: each column starts at the bowl's surface instead.
  const Layers layers{.spacing = spacing_for({bolt, nut}), .layers = 2, .bottom = 0};
  const double half_side = layers.spacing * static_cast<double>(layers.side(bodies)) / 2;
  const double rim = half_side * std::numbers::sqrt2 + 2 * layers.spacing;
  const int segments = std::clamp(static_cast<int>(std::numbers::pi * rim), 48, 512);
  const BowlSize bowl{
      .sphere_radius = 1.5 * rim, .rim_radius = rim, .thickness = 2, .segments = segments, .bands = segments / 4};
  add_fixed(scene, scene.add_shape(Shape(make_bowl(bowl)), "bowl"));
  for (std::size_t k = 0; k < bodies; ++k) {
    Vec3 cell = layers.cell(k, bodies);
    // The surface is steepest at the cell's outer corner.
    const double outermost = std::hypot(cell.x(), cell.y()) + layers.spacing * std::numbers::sqrt2 / 2;
    cell.z() += bowl_height(bowl, outermost) + bowl_sagitta(bowl);
    scene.add_body(tumbled(random.bits() % 2 == 0 ? bolt : nut, cell, layers.spacing, random));
  }
  return scene;
}

Scene tori_on_cones(std::size_t bodies, Random& random) {
  Scene scene;
  add_ground(scene);
  const double cone_radius = 0.8, cone_height = 1.2, cone_spacing = 2.6;
  const Kind torus = add_torus(scene);
  const Layers layers{.spacing = spacing_for({torus}), .layers = 2, .bottom = cone_height + 0.05};
  // One row of cones beyond the tori, which spread as they pile up.
  const double width = layers.spacing * static_cast<double>(layers.side(bodies)) + 2 * cone_spacing;
  const auto cones = static_cast<std::size_t>(std::ceil(width / cone_spacing));
  const ShapeId cone = scene.add_shape(Shape(make_cone(cone_radius, cone_height, 24, 4)), "cone");
  const Layers field{.spacing = cone_spacing, .layers = 1, .bottom = 0};
  for (std::size_t k = 0; k < cones * cones; ++k) {
    const Vec3 cell = field.cell(k, cones * cones);
    add_fixed(scene, cone, Pose::at(cell.x(), cell.y(), 0));
  }
  for (std::size_t k = 0; k < bodies; ++k)
    scene.add_body(tumbled(torus, layers.cell(k, bodies), layers.spacing, random));
  return scene;
}

Scene dropped_on_plane(Kind (*add_kind)(Scene&), double loose, std::size_t bodies, Random& random) {
  Scene scene;
  add_ground(scene);
  const Kind kind = add_kind(scene);
  const Layers layers{.spacing = spacing_for({kind}, loose), .layers = 2, .bottom = 0.05};
  for (std::size_t k = 0; k < bodies; ++k)
    scene.add_body(tumbled(kind, layers.cell(k, bodies), layers.spacing, random));
  return scene;
}

Scene cubes_on_plane(std::size_t bodies, Random& random) { return dropped_on_plane(add_cube, 1.04, bodies, random); }
// Spheres need more jitter, or they balance on each other.
Scene spheres_on_plane(std::size_t bodies, Random& random) { return dropped_on_plane(add_sphere, 1.3, bodies, random); }
Scene tori_on_plane(std::size_t bodies, Random& random) { return dropped_on_plane(add_torus, 1.04, bodies, random); }

Scene tori_and_cubes(std::size_t bodies, Random& random) {
  Scene scene;
  add_ground(scene);
  const Kind torus = add_torus(scene), cube = add_cube(scene);
  const Layers layers{.spacing = spacing_for({torus, cube}), .layers = 2, .bottom = 0.05};
  for (std::size_t k = 0; k < bodies; ++k)
    scene.add_body(tumbled(k % 3 == 0 ? torus : cube, layers.cell(k, bodies), layers.spacing, random));
  return scene;
}

Scene falling_apart(std::size_t bodies, Random& random) {
  Scene scene;
  const Kind cube = add_cube(scene), sphere = add_sphere(scene);
  const auto cells_across = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(bodies))));
  const Layers layers{.spacing = 1.2 * spacing_for({cube, sphere}), .layers = cells_across, .bottom = 0};
  for (std::size_t k = 0; k < bodies; ++k) {
    BodyOptions body = tumbled(k % 2 == 0 ? cube : sphere, layers.cell(k, bodies), layers.spacing, random);
    // All fall at one speed, so turning is all they do beside it, within the balls they have to themselves.
    for (int axis = 0; axis < 3; ++axis) body.angular_velocity[axis] = random.uniform(-2, 2);
    scene.add_body(body);
  }
  return scene;
}

Scene complex_in_contact(std::size_t bodies, Random& random) {
  Scene scene;
  add_ground(scene);
  const double ring = 0.6, tube = 0.25;
  const Kind torus = add_mesh(scene, make_torus(ring, tube, 96, 48), "fine torus");
  const Layers layers{.spacing = 1, .layers = 2, .bottom = 0};
  // A thousandth of overlap on each side: rounding does not decide what touches.
  const double touching = 0.999;
  for (std::size_t k = 0; k < bodies; ++k) {
    const Vec3 cell = layers.cell(k, bodies);
    BodyOptions body;
    body.shape = torus.shape;
    const CosSin turn = cos_sin_of_turn(static_cast<int>(random.bits() % 96), 96);
    body.pose.rotation << turn.cos, -turn.sin, 0, turn.sin, turn.cos, 0, 0, 0, 1;
    body.pose.translation = {cell.x() * 2 * (ring + tube) * touching, cell.y() * 2 * (ring + tube) * touching,
                             cell.z() * 2 * tube * touching};
    scene.add_body(body);
  }
  return scene;
}

constexpr std::array<Scene (*)(std::size_t, Random&), table.size()> makers{
    screws_in_bowl, tori_on_cones,  cubes_on_plane, spheres_on_plane,
    tori_on_plane,  tori_and_cubes, falling_apart,  complex_in_contact};

}  // namespace

std::span<const BuiltinScene> builtin_scenes() { return table; }

Scene make_builtin_scene(std::string_view name, std::size_t bodies, std::uint64_t seed) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const BuiltinScene& s) { return s.name == name; });
  if (found == table.end()) {
    std::string message = "scene is '" + std::string(name) + "', allowed:";
    for (const BuiltinScene& known : table) message.append(" ").append(known.name);
    throw std::invalid_argument(message);
  }
  if (bodies > most_bodies)
    throw std::invalid_argument("bodies is " + std::to_string(bodies) + ", allowed: 1 to " +
                                std::to_string(most_bodies) + ", or 0 for the scene's own size");
  Random random(seed);
  Scene scene = makers[static_cast<std::size_t>(found - table.begin())](bodies == 0 ? found->bodies : bodies, random);
  scene.name = name;
  return scene;
}

}  // namespace tandem
