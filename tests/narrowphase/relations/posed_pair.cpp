// Pairs of posed shapes: as records, scaled, moved, exchanged.
#include "posed_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "shapes/shape_insides.h"

namespace tandem::relations {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;  // clang 14 does not deduce it

using Json = nlohmann::ordered_json;

Json json(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }

template <class Points>
Json points(const Points& vertices) {
  Json all = Json::array();
  for (const Vec3& v : vertices) all.push_back(json(v));
  return all;
}

Json json(const ShapeData& data) {
  Json j{{"kind", name(static_cast<ShapeKind>(data.index()))}};
  std::visit(
      Overloaded{[&](const Sphere& s) { j["radius"] = s.radius; }, [&](const Box& s) { j["size"] = json(s.size); },
                 [&](const Ellipsoid& s) { j["radii"] = json(s.radii); },
                 [&](const HalfSpace& s) { j["normal"] = json(s.normal), j["offset"] = s.offset; },
                 [&](const Plane& s) { j["normal"] = json(s.normal), j["offset"] = s.offset; },
                 [&](const Convex& s) { j["vertices"] = points(s.vertices); },
                 [&](const Triangle& s) { j["vertices"] = points(s.vertices); },
                 [&](const Mesh& s) {
                   j["vertices"] = points(s.vertices), j["triangles"] = s.triangles;
                   if (s.solid) j["solid"] = true;
                 },
                 [&](const Voxels& s) {
                   j["cell_size"] = s.cell_size, j["origin"] = json(s.origin);
                   for (const auto& [c, level] : s.cells) j["cells"].push_back({c[0], c[1], c[2], level});
                 },
                 [&](const auto& s) { j["radius"] = s.radius, j["length"] = s.length; }},
      data);
  return j;
}

Json json(const PosedShape& posed) {
  Json j = json(posed.shape);
  if (posed.rounding > 0) j["rounding"] = posed.rounding;
  return j;
}

Json json(const Pose& pose) {
  return {{"t", json(pose.translation)},
          {"R", Json::array({json(pose.rotation.row(0)), json(pose.rotation.row(1)), json(pose.rotation.row(2))})}};
}

/// The largest side of a box about the vertices; 0 of shapes that have none.
double extent(const ShapeData& data) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const auto cover = [&](const auto& points) {
    for (const Vec3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  };
  std::visit(Overloaded{[&](const Convex& s) { cover(s.vertices); }, [&](const Triangle& s) { cover(s.vertices); },
                        [&](const Mesh& s) { cover(s.vertices); },
                        [&](const Voxels& s) {
                          const Bounds box = Shape(s).bounds({});
                          cover(std::array{box.lo, box.hi});
                        },
                        [](const auto&) {}},
             data);
  return low.x() <= high.x() ? (high - low).maxCoeff() : 0;
}

/// Calls take(length) for every number of a shape that is a length.
template <class Data, class Take>
void each_length(Data& data, Take&& take) {
  const auto all = [&](auto& points) {
    for (auto& p : points)
      for (auto& x : p) take(x);
  };
  std::visit(
      Overloaded{[&](Sphere& s) { take(s.radius); }, [&](Box& s) { std::for_each(s.size.begin(), s.size.end(), take); },
                 [&](Ellipsoid& s) { std::for_each(s.radii.begin(), s.radii.end(), take); },
                 [&](HalfSpace& s) { take(s.offset); }, [&](Plane& s) { take(s.offset); },
                 [&](Convex& s) { all(s.vertices); }, [&](Triangle& s) { all(s.vertices); },
                 [&](Mesh& s) { all(s.vertices); },
                 [&](Voxels& s) { take(s.cell_size), std::for_each(s.origin.begin(), s.origin.end(), take); },
                 [&](auto& s) { take(s.radius), take(s.length); }},
      data);
}

}  // namespace

Shape make_shape(const ShapeData& data) {
  return std::visit([](const auto& s) { return Shape(s); }, data);
}

Shape make_shape(const PosedShape& posed) {
  const Shape core = make_shape(posed.shape);
  return posed.rounding > 0 ? core.rounded(posed.rounding) : core;
}

ShapeData data_of(const Shape& s) {
  switch (s.kind()) {
    case ShapeKind::sphere:
      return Sphere{s.radius()};
    case ShapeKind::box:
      return Box{2 * s.half_size()};
    case ShapeKind::capsule:
      return Capsule{s.radius(), s.length()};
    case ShapeKind::cylinder:
      return Cylinder{s.radius(), s.length()};
    case ShapeKind::cone:
      return Cone{s.radius(), s.length()};
    case ShapeKind::ellipsoid:
      return Ellipsoid{s.radii()};
    case ShapeKind::halfspace:
      return HalfSpace{s.normal(), s.offset()};
    case ShapeKind::plane:
      return Plane{s.normal(), s.offset()};
    case ShapeKind::voxels:
      return Voxels{{s.cells().begin(), s.cells().end()}, s.cell_size(), s.origin()};
    case ShapeKind::convex:
      return Convex{hull_of(s).vertices};
    case ShapeKind::triangle: {
      // A triangle without area has fewer extreme points than corners.
      const auto& v = hull_of(s).vertices;
      const auto corner = [&](std::size_t k) { return v[std::min(k, v.size() - 1)]; };
      return Triangle{{corner(0), corner(1), corner(2)}};
    }
    default:
      return Mesh{mesh_of(s).vertices, mesh_of(s).triangles, mesh_of(s).solid};
  }
}

double reach(const ShapeData& data) {
  const auto farthest = [](const auto& points) {
    double most = 0;
    for (const Vec3& p : points) most = std::max(most, p.norm());
    return most;
  };
  return std::visit(Overloaded{[](const Sphere& s) { return s.radius; }, [](const Box& s) { return s.size.norm() / 2; },
                               [](const Capsule& s) { return s.radius + s.length / 2; },
                               [](const Ellipsoid& s) { return s.radii.maxCoeff(); },
                               [](const HalfSpace& s) { return std::abs(s.offset) / s.normal.norm(); },
                               [](const Plane& s) { return std::abs(s.offset) / s.normal.norm(); },
                               [&](const Convex& s) { return farthest(s.vertices); },
                               [&](const Triangle& s) { return farthest(s.vertices); },
                               [&](const Mesh& s) { return farthest(s.vertices); },
                               [](const Voxels& s) {
                                 const Bounds b = Shape(s).bounds({});
                                 return b.lo.cwiseAbs().cwiseMax(b.hi.cwiseAbs()).norm();
                               },
                               [](const auto& s) { return std::hypot(s.radius, s.length / 2); }},
                    data);
}

double reach(const PosedShape& posed) { return reach(posed.shape) + posed.rounding; }

double unit_of(const PosedPair& p) {
  return reach(p.a) + reach(p.b) + (p.b.pose.translation - p.a.pose.translation).norm();
}

void scale(ShapeData& data, double factor) {
  each_length(data, [&](double& x) { x *= factor; });
}

void scale(PosedPair& pair, double factor) {
  for (PosedShape* s : {&pair.a, &pair.b}) {
    scale(s->shape, factor);
    s->rounding *= factor;
    s->pose.translation *= factor;
  }
  pair.margin *= factor;
}

bool can_scale(const PosedPair& pair, double factor) {
  // Vertices and translations may be any number up to 1e30; if their square is not a normal number, bits are lost.
  constexpr double least = 1e-29, most = 1e29;
  bool can = true;
  const auto check = [&](double x) {
    can = can && (x == 0 || (std::abs(x) * factor > least && std::abs(x) * factor < most));
  };
  for (const PosedShape* s : {&pair.a, &pair.b}) {
    ShapeData data = s->shape;
    each_length(data, [&](double& x) { check(x); });
    check(extent(data));
    check(s->rounding);
    for (const double x : s->pose.translation) check(x);
  }
  check(pair.margin);
  return can;
}

std::string record(const PosedPair& p, const std::string& id) {
  Json j{{"id", id},
         {"shapeA", json(p.a)},
         {"poseA", json(p.a.pose)},
         {"shapeB", json(p.b)},
         {"poseB", json(p.b.pose)},
         {"margin", p.margin},
         {"ask", {"collide", "distance", "normal", "contacts"}}};
  return j.dump();
}

}  // namespace tandem::relations
