// The built-in scenes: bodies that fall on planes, cones or into bowls, and beds of grains.
#include "tandem/engine/builtin_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "scene/mesh_generators.h"
#include "scene/random.h"

namespace tandem {
namespace {

constexpr std::size_t most_bodies = 1'000'000;

constexpr std::array<BuiltinScene, 10> table{{
    {"screws-in-bowl", "threaded bolts and nuts, solid meshes, falling into a bowl", 500},
    {"tori-on-cones", "tori of 1152 triangles falling on a field of cones", 2000},
    {"cubes-on-plane", "boxes falling on a plane", 3000},
    {"spheres-on-plane", "spheres falling on a plane", 2500},
    {"tori-on-plane", "tori of 1152 triangles falling on a plane", 1000},
    {"tori-and-cubes", "one torus to two boxes falling on a plane: pairs of very unequal cost", 1500},
    {"falling-apart", "spheres and boxes in free fall that never meet", 20000},
    {"complex-in-contact", "finely tessellated tori stacked so that all touch from the first step", 8},
    {"grains", "spheres, each with a radius of its own, falling into a bed in a box", 100000},
    {"mixed-grains", "spheres, ellipsoids, hulls and boxes with round edges falling into a bed in a box", 20000},
}};

/// A kind of dropped bodies: their common data and size.
struct Kind {
  ShapeId shape;
  double radius;  ///< of a ball about the shape's origin that contains it
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

/// Positions in horizontal layers of a square grid about the z axis, filled from below. Each is the centre of a ball of
/// diameter `spacing` that overlaps no other. Odd layers are shifted over the gaps of even ones, so that bodies pile up
/// after a short fall.
struct Layers {
  double spacing;
  std::size_t layers;  ///< up to so many; more bodies make the layers wider
  double bottom;       ///< height of the lowest point of the lowest balls

  std::size_t side(std::size_t bodies) const {
    auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(bodies) / static_cast<double>(layers)));
    while (side * side * layers < bodies) ++side;
    return side;
  }
  std::size_t layer(std::size_t k, std::size_t bodies) const { return k / (side(bodies) * side(bodies)); }
  Vec3 place(std::size_t k, std::size_t bodies) const {
    const std::size_t across = side(bodies), up = layer(k, bodies);
    const double first = (static_cast<double>(up % 2) - static_cast<double>(across)) / 2 + 0.25;
    return {(static_cast<double>(k % across) + first) * spacing,
            (static_cast<double>(k / across % across) + first) * spacing,
            bottom + spacing / 2 + static_cast<double>(up) * spacing * std::numbers::sqrt2 / 2};
  }
};

/// A body at the place, turned and shifted at random within its ball of diameter `spacing`.
BodyOptions tumbled(const Kind& kind, const Vec3& place, double spacing, Random& random) {
  constexpr double used = 0.98;  // share of the ball's free radius: what is left keeps neighbours apart
  const double room = std::max(0.0, used * (spacing / 2 - kind.radius)) / std::numbers::sqrt3;
  BodyOptions body;
  body.shape = kind.shape;
  body.pose.rotation = random.rotation();
  for (int axis = 0; axis < 3; ++axis) body.pose.translation[axis] = place[axis] + random.uniform(-room, room);
  return body;
}

/// The spacing of positions in diameters of the largest body: the part above 1 leaves room for random shifts.
constexpr double usual_spacing = 1.04;
constexpr double spacing_of_spheres = 1.2;  // less would let them balance on each other

double spacing_for(std::initializer_list<Kind> kinds, double diameters = usual_spacing) {
  double radius = 0;
  for (const Kind& kind : kinds) radius = std::max(radius, kind.radius);
  return diameters * 2 * radius;
}

/// The height of the centre of a ball that lies in the bowl at that distance from the axis.
double ball_height(const BowlSize& bowl, double radius, double distance) {
  const double reach = bowl.sphere_radius - radius;
  return bowl.sphere_radius - std::sqrt(std::max(0.0, reach * reach - distance * distance));
}

Scene screws_in_bowl(std::size_t bodies, Random& random) {
  Scene scene;
  const Thread outer{.root_radius = 0.32, .crest_radius = 0.39, .pitch = 0.26, .turns = 4};
  const Thread inner{.root_radius = 0.48, .crest_radius = 0.41, .pitch = 0.26, .turns = 3};
  const Kind bolt =
      add_mesh(scene, make_bolt({.thread = outer, .head_radius = 0.65, .head_height = 0.45, .segments = 12}), "bolt");
  const Kind nut = add_mesh(scene, make_nut({.thread = inner, .corner_radius = 0.78, .segments = 12}), "nut");

  // In horizontal layers those over the middle would fall far: each column starts at the bowl's surface instead.
  const Layers layers{.spacing = spacing_for({bolt, nut}), .layers = 2, .bottom = 0.02};
  const double half_side = layers.spacing * static_cast<double>(layers.side(bodies)) / 2;
  const double rim = half_side * std::numbers::sqrt2 + 2 * layers.spacing;
  const int segments = std::clamp(static_cast<int>(std::numbers::pi * rim), 48, 512);
  const BowlSize bowl{
      .sphere_radius = 3 * rim, .rim_radius = rim, .thickness = 2, .segments = segments, .bands = segments / 4};
  add_fixed(scene, scene.add_shape(Shape(make_bowl(bowl)), "bowl"));
  for (std::size_t k = 0; k < bodies; ++k) {
    Vec3 place = layers.place(k, bodies);
    // The lowest balls rest on the surface; balls above them keep their distance from the highest of their four
    // supports.
    const double above = layers.layer(k, bodies) > 0 ? layers.spacing * std::numbers::sqrt2 / 2 : 0;
    place.z() += ball_height(bowl, layers.spacing / 2, std::hypot(place.x(), place.y()) + above) - layers.spacing / 2 +
                 bowl_sagitta(bowl);
    scene.add_body(tumbled(random.bits() % 2 == 0 ? bolt : nut, place, layers.spacing, random));
  }
  return scene;
}

Scene tori_on_cones(std::size_t bodies, Random& random) {
  Scene scene;
  add_ground(scene);
  const double cone_radius = 0.8, cone_height = 0.8, cone_spacing = 2.4;
  const Kind torus = add_torus(scene);
  const Layers layers{.spacing = spacing_for({torus}), .layers = 2, .bottom = cone_height + 0.05};
  // One row of cones beyond the tori, which spread as they pile up.
  const double width = layers.spacing * static_cast<double>(layers.side(bodies)) + 2 * cone_spacing;
  const auto cones = static_cast<std::size_t>(std::ceil(width / cone_spacing));
  const ShapeId cone = scene.add_shape(Shape(make_cone(cone_radius, cone_height, 24, 4)), "cone");
  const Layers field{.spacing = cone_spacing, .layers = 1, .bottom = 0};
  for (std::size_t k = 0; k < cones * cones; ++k) {
    const Vec3 place = field.place(k, cones * cones);
    add_fixed(scene, cone, Pose::at(place.x(), place.y(), 0));
  }
  for (std::size_t k = 0; k < bodies; ++k)
    scene.add_body(tumbled(torus, layers.place(k, bodies), layers.spacing, random));
  return scene;
}

Scene dropped_on_plane(Kind (*add_kind)(Scene&), double diameters, std::size_t bodies, Random& random) {
  Scene scene;
  add_ground(scene);
  const Kind kind = add_kind(scene);
  const Layers layers{.spacing = spacing_for({kind}, diameters), .layers = 2, .bottom = 0.05};
  for (std::size_t k = 0; k < bodies; ++k)
    scene.add_body(tumbled(kind, layers.place(k, bodies), layers.spacing, random));
  return scene;
}

Scene cubes_on_plane(std::size_t bodies, Random& random) {
  return dropped_on_plane(add_cube, usual_spacing, bodies, random);
}
Scene spheres_on_plane(std::size_t bodies, Random& random) {
  return dropped_on_plane(add_sphere, spacing_of_spheres, bodies, random);
}
Scene tori_on_plane(std::size_t bodies, Random& random) {
  return dropped_on_plane(add_torus, usual_spacing, bodies, random);
}

Scene tori_and_cubes(std::size_t bodies, Random& random) {
  Scene scene;
  add_ground(scene);
  const Kind torus = add_torus(scene), cube = add_cube(scene);
  const Layers layers{.spacing = spacing_for({torus, cube}), .layers = 2, .bottom = 0.05};
  for (std::size_t k = 0; k < bodies; ++k)
    scene.add_body(tumbled(k % 3 == 0 ? torus : cube, layers.place(k, bodies), layers.spacing, random));
  return scene;
}

Scene falling_apart(std::size_t bodies, Random& random) {
  Scene scene;
  const Kind cube = add_cube(scene), sphere = add_sphere(scene);
  const auto cells_across = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(bodies))));
  const Layers layers{.spacing = 1.2 * spacing_for({cube, sphere}), .layers = cells_across, .bottom = 0};
  for (std::size_t k = 0; k < bodies; ++k) {
    BodyOptions body = tumbled(k % 2 == 0 ? cube : sphere, layers.place(k, bodies), layers.spacing, random);
    // All fall at the same speed, so their relative motion is rotation alone, within their own balls.
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
  constexpr double pressed = 0.999;  // of the distance at which they would touch: rounding does not decide the contacts
  const double across = pressed * 2 * (ring + tube), up = pressed * 2 * tube;
  const Layers stacks{.spacing = across, .layers = 1, .bottom = 0};
  const std::size_t height = 2, count = (bodies + height - 1) / height;
  for (std::size_t k = 0; k < bodies; ++k) {
    const Vec3 place = stacks.place(k % count, count);
    BodyOptions body;
    body.shape = torus.shape;
    const CosSin turn = cos_sin_of_turn(static_cast<int>(random.bits() % 96), 96);
    body.pose.rotation << turn.cos, -turn.sin, 0, turn.sin, turn.cos, 0, 0, 0, 1;
    body.pose.translation = {place.x(), place.y(), (static_cast<double>(k / count) + 0.5) * up};
    scene.add_body(body);
  }
  return scene;
}

/// The largest grain's radius, metres; the smallest is half of it.
constexpr double grain_radius = 0.6;

/// Layers above the floor of a box with half-spaces as walls. There are so few that the highest bodies do not fall by
/// more than a quarter of the smallest diameter in a step.
Layers add_box(Scene& scene, std::size_t bodies) {
  const Layers layers{.spacing = usual_spacing * 2 * grain_radius, .layers = 12, .bottom = 0.05};
  add_ground(scene);
  const double half_width = layers.spacing * (static_cast<double>(layers.side(bodies)) / 2 + 0.25);
  for (const Vec3& inward : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)})
    add_fixed(scene, scene.add_shape(Shape(HalfSpace{inward, -half_width}), "wall"));
  return layers;
}

Scene grains(std::size_t bodies, Random& random) {
  Scene scene;
  const Layers layers = add_box(scene, bodies);
  scene.reserve(scene.indices() + bodies, scene.shapes().size() + bodies);
  for (std::size_t k = 0; k < bodies; ++k) {
    const double radius = random.uniform(grain_radius / 2, grain_radius);
    const Kind grain{scene.add_shape(Shape(Sphere{radius})), radius};
    scene.add_body(tumbled(grain, layers.place(k, bodies), layers.spacing, random));
  }
  return scene;
}

Kind add_hull(Scene& scene, double radius, Random& random) {
  Convex hull;
  for (int k = 0; k < 16; ++k) {
    const double distance = radius * random.uniform(0.8, 1);
    hull.vertices.emplace_back(distance * random.rotation().col(0));
  }
  return {scene.add_shape(Shape(hull), "hull"), radius};
}

/// The sizes of each kind of grain, from a sieve curve, in turn: sphere, ellipsoid, hull, box with round edges.
std::vector<Kind> add_mixed_kinds(Scene& scene, Random& random) {
  std::vector<Kind> kinds;
  const auto part = [&random](double whole) { return whole * random.uniform(0.6, 1); };
  for (int sieve = 0; sieve < 16; ++sieve) {
    const double radius = random.uniform(grain_radius / 2, grain_radius);
    kinds.push_back({scene.add_shape(Shape(Sphere{radius}), "sphere"), radius});
    const Ellipsoid ellipsoid{{radius, part(radius), part(radius)}};
    kinds.push_back({scene.add_shape(Shape(ellipsoid), "ellipsoid"), radius});
    kinds.push_back(add_hull(scene, radius, random));
    const double rounding = 0.2 * radius, edge = 2 * (radius - rounding) / std::numbers::sqrt3;
    const Box box{{edge, part(edge), part(edge)}};
    kinds.push_back({scene.add_shape(Shape(box).rounded(rounding), "round box"), radius});
  }
  return kinds;
}

Scene mixed_grains(std::size_t bodies, Random& random) {
  Scene scene;
  const Layers layers = add_box(scene, bodies);
  const std::vector<Kind> kinds = add_mixed_kinds(scene, random);
  scene.reserve(scene.indices() + bodies);
  for (std::size_t k = 0; k < bodies; ++k) {
    const Kind& kind = kinds[random.bits() % kinds.size()];
    scene.add_body(tumbled(kind, layers.place(k, bodies), layers.spacing, random));
  }
  return scene;
}

constexpr std::array<Scene (*)(std::size_t, Random&), table.size()> makers{
    screws_in_bowl, tori_on_cones, cubes_on_plane,     spheres_on_plane, tori_on_plane,
    tori_and_cubes, falling_apart, complex_in_contact, grains,           mixed_grains};

}  // namespace

std::span<const BuiltinScene> builtin_scenes() { return table; }

Scene make_builtin_scene(std::string_view name, std::size_t bodies, std::uint64_t seed) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const BuiltinScene& s) { return s.name == name; });
  if (found == table.end()) {
    constexpr std::size_t longest_quote = 64;
    std::string message = "scene is '" + std::string(name.substr(0, longest_quote)) + "', allowed:";
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
