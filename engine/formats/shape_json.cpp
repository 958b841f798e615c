// Shapes and poses as JSON (docs/scene-format.md).
#include "formats/shape_json.h"

#include <array>
#include <cmath>
#include <functional>

#include "formats/text_file.h"
#include "scene/tolerances.h"
#include "tandem/formats/mesh_file.h"

namespace tandem {
namespace {

// Makes a shape; an error of the shape's own checks, which do not know the document, is given its place there.
template <typename Parameters>
Shape make_shape(const JsonRef& json, Parameters&& parameters) {
  try {
    return Shape(std::forward<Parameters>(parameters));
  } catch (const std::invalid_argument& error) {
    json.refuse(error.what(), {});
  }
}

Vec3 sizes(const JsonRef& json) {
  const Vec3 v = json.vec3();
  for (std::size_t i = 0; i < 3; ++i) json.at(i).number_above(0);
  return v;
}

std::vector<Vec3> points(const JsonRef& json) {
  json.require_array("an array of points [x, y, z]");
  std::vector<Vec3> out;
  out.reserve(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) out.push_back(json.at(i).vec3());
  return out;
}

std::vector<Vec3> some_points(const JsonRef& json) {
  std::vector<Vec3> out = points(json);
  if (out.empty()) json.refuse("one or more points [x, y, z]");
  return out;
}

std::array<Vec3, 3> three_points(const JsonRef& json) {
  json.require_array("three points [x, y, z]");
  if (json.size() != 3) json.refuse("three points [x, y, z]");
  const std::vector<Vec3> corners = points(json);
  return {corners[0], corners[1], corners[2]};
}

void write_vertices(JsonWriter& out, const Shape& shape) {
  out.key("vertices").begin_array();
  for (const Vec3& v : shape.vertices()) out.value(v);
  out.end_array();
}

void write_radius_and_length(JsonWriter& out, const Shape& shape) {
  out.member("radius", shape.radius()).member("length", shape.length());
}

void write_normal_and_offset(JsonWriter& out, const Shape& shape) {
  out.member("normal", shape.normal()).member("offset", shape.offset());
}

void write_mesh(JsonWriter& out, const Shape& shape) {
  write_vertices(out, shape);
  out.key("triangles").begin_array();
  for (const auto& [i, j, k] : shape.triangles()) out.begin_array().value(i).value(j).value(k).end_array();
  out.end_array().member("solid", shape.is_solid());
}

/// [i, j, k], or with a level [i, j, k, l]; make_shape says which numbers are allowed.
VoxelCell voxel_cell(const JsonRef& json) {
  constexpr std::string_view allowed = "whole numbers [i, j, k] or [i, j, k, level]";
  json.require_array(allowed);
  if (json.size() != 3 && json.size() != 4) json.refuse(allowed);
  constexpr double most = 1 << 21;  // what is beyond is refused with the grid's own bounds
  VoxelCell cell;
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = json.at(k).number();
    if (at != std::floor(at) || std::abs(at) > most) json.at(k).refuse("a whole number from -2^20 to 2^20 - 1");
    cell.corner[k] = static_cast<std::int32_t>(at);
  }
  if (json.size() == 4) cell.level = static_cast<std::uint8_t>(json.at(3).whole(20));
  return cell;
}

Voxels voxels(const JsonRef& json) {
  json.require_keys({"kind", "cells", "cell_size", "origin", "rounding"});
  Voxels grid;
  const JsonRef cells = json.at("cells");
  cells.require_array("an array of cells [i, j, k]");
  grid.cells.reserve(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) grid.cells.push_back(voxel_cell(cells.at(i)));
  grid.cell_size = json.at("cell_size").number_above(0);
  if (const auto origin = json.find("origin")) grid.origin = origin->vec3();
  return grid;
}

void write_voxels(JsonWriter& out, const Shape& shape) {
  out.member("cell_size", shape.cell_size()).member("origin", shape.origin()).key("cells").begin_array();
  for (const VoxelCell& cell : shape.cells()) {
    out.begin_array();
    for (const std::int32_t at : cell.corner) out.value(at);
    if (cell.level > 0) out.value(static_cast<std::int32_t>(cell.level));
    out.end_array();
  }
  out.end_array();
}

using ReadMesh = std::function<Shape(const JsonRef& json)>;

/// The JSON form of a kind, without its rounding.
struct JsonKind {
  ShapeKind kind;
  Shape (*read)(const JsonRef& json, const ReadMesh& read_mesh);
  void (*write)(JsonWriter& out, const Shape& shape);
};

using In = const JsonRef&;
using Meshes = const ReadMesh&;
using Out = JsonWriter&;

constexpr std::array<JsonKind, shape_kinds> json_kinds = {{
    {ShapeKind::sphere,
     [](In json, Meshes) {
       json.require_keys({"kind", "radius", "rounding"});
       return make_shape(json, Sphere{json.at("radius").number_at_least(0)});
     },
     [](Out out, const Shape& shape) { out.member("radius", shape.radius()); }},
    {ShapeKind::box,
     [](In json, Meshes) {
       json.require_keys({"kind", "size", "rounding"});
       return make_shape(json, Box{sizes(json.at("size"))});
     },
     [](Out out, const Shape& shape) { out.member("size", Vec3(2 * shape.half_size())); }},
    {ShapeKind::capsule,
     [](In json, Meshes) {
       json.require_keys({"kind", "radius", "length", "rounding"});
       return make_shape(json, Capsule{json.at("radius").number_above(0), json.at("length").number_at_least(0)});
     },
     write_radius_and_length},
    {ShapeKind::cylinder,
     [](In json, Meshes) {
       json.require_keys({"kind", "radius", "length", "rounding"});
       return make_shape(json, Cylinder{json.at("radius").number_above(0), json.at("length").number_above(0)});
     },
     write_radius_and_length},
    {ShapeKind::cone,
     [](In json, Meshes) {
       json.require_keys({"kind", "radius", "length", "rounding"});
       return make_shape(json, Cone{json.at("radius").number_above(0), json.at("length").number_above(0)});
     },
     write_radius_and_length},
    {ShapeKind::ellipsoid,
     [](In json, Meshes) {
       json.require_keys({"kind", "radii", "rounding"});
       return make_shape(json, Ellipsoid{sizes(json.at("radii"))});
     },
     [](Out out, const Shape& shape) { out.member("radii", shape.radii()); }},
    {ShapeKind::halfspace,
     [](In json, Meshes) {
       json.require_keys({"kind", "normal", "offset", "rounding"});
       return make_shape(json, HalfSpace{json.at("normal").vec3(), json.at("offset").number()});
     },
     write_normal_and_offset},
    {ShapeKind::convex,
     [](In json, Meshes) {
       json.require_keys({"kind", "vertices", "rounding"});
       return make_shape(json, Convex{some_points(json.at("vertices"))});
     },
     write_vertices},
    {ShapeKind::triangle,
     [](In json, Meshes) {
       json.require_keys({"kind", "vertices", "rounding"});
       return make_shape(json, Triangle{three_points(json.at("vertices"))});
     },
     write_vertices},
    {ShapeKind::mesh, [](In json, Meshes read_mesh) { return read_mesh(json); }, write_mesh},
    {ShapeKind::plane,
     [](In json, Meshes) {
       json.require_keys({"kind", "normal", "offset", "rounding"});
       return make_shape(json, Plane{json.at("normal").vec3(), json.at("offset").number()});
     },
     write_normal_and_offset},
    {ShapeKind::voxels, [](In json, Meshes) { return make_shape(json, voxels(json)); }, write_voxels},
}};
static_assert(
    [] {
      for (std::size_t i = 0; i < shape_kinds; ++i)
        if (json_kinds[i].kind != static_cast<ShapeKind>(i) || json_kinds[i].write == nullptr) return false;
      return true;
    }(),
    "each kind has a row, in the order of ShapeKind");

const JsonKind& json_kind(const JsonRef& name_json) {
  std::string known;
  for (const JsonKind& row : json_kinds) {
    if (name(row.kind) == name_json.text()) return row;
    known += (known.empty() ? "" : ", ") + std::string(name(row.kind));
  }
  name_json.refuse(known);
}

}  // namespace

Shape ShapeReader::mesh(const JsonRef& json) {
  json.require_keys({"kind", "vertices", "triangles", "file", "solid", "rounding"});
  const auto solid_flag = json.find("solid");
  const bool solid = solid_flag && solid_flag->flag();
  if (const auto file = json.find("file")) {
    if (json.find("vertices") || json.find("triangles"))
      json.refuse("both file and vertices or triangles", "one of them");
    std::filesystem::path path = folders_.front() / file->text();
    for (const auto& folder : folders_) {
      std::error_code ignored;
      if (!std::filesystem::exists(folder / file->text(), ignored)) continue;
      path = folder / file->text();
      break;
    }
    // A file may have many names: compare its canonical path.
    std::error_code unknown;
    const std::filesystem::path one_name = std::filesystem::weakly_canonical(path, unknown);
    const std::pair key((unknown ? path : one_name).string(), solid);
    if (const auto known = mesh_files_.find(key); known != mesh_files_.end()) return known->second;
    try {
      const InputFile must_be_regular(path, InputFile::Kind::regular);
      return mesh_files_.emplace(key, read_mesh_shape(path, solid)).first->second;
    } catch (const InputError& error) {
      throw error.within(file->pointer());
    }
  }
  Mesh mesh;
  mesh.solid = solid;
  mesh.vertices = some_points(json.at("vertices"));
  const JsonRef triangles = json.at("triangles");
  triangles.require_array("an array of triangles [i, j, k]");
  if (triangles.size() == 0) triangles.refuse("one or more triangles [i, j, k]");
  mesh.triangles.reserve(triangles.size());
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const JsonRef triangle = triangles.at(i);
    triangle.require_array("three vertex numbers [i, j, k]");
    if (triangle.size() != 3) triangle.refuse("three vertex numbers [i, j, k]");
    mesh.triangles.push_back({triangle.at(0).whole(last), triangle.at(1).whole(last), triangle.at(2).whole(last)});
  }
  return make_shape(json, std::move(mesh));
}

Shape ShapeReader::read(const JsonRef& json) {
  const Shape core = read_core(json);
  const auto rounding = json.find("rounding");
  if (!rounding) return core;
  const double radius = rounding->number_at_least(0);
  try {
    return core.rounded(radius);
  } catch (const std::invalid_argument& error) {
    json.refuse(error.what(), {});
  }
}

Shape ShapeReader::read_core(const JsonRef& json) {
  return json_kind(json.at("kind")).read(json, [this](const JsonRef& mesh_json) { return mesh(mesh_json); });
}

Pose read_pose(const JsonRef& json) {
  json.require_keys({"t", "R", "q"});
  Pose pose;
  pose.translation = json.at("t").vec3();
  const auto rows = json.find("R"), quaternion = json.find("q");
  if (rows && quaternion) json.refuse("both R and q", "one of them");
  if (rows) {
    rows->require_array("three rows of three numbers");
    if (rows->size() != 3) rows->refuse("three rows of three numbers");
    for (std::size_t i = 0; i < 3; ++i) pose.rotation.row(static_cast<Eigen::Index>(i)) = rows->at(i).vec3();
  }
  if (quaternion) {
    constexpr std::string_view allowed = tolerance::quaternion_range;
    quaternion->require_array(allowed);
    if (quaternion->size() != 4) quaternion->refuse(allowed);
    const Quat q(quaternion->at(0).number(), quaternion->at(1).number(), quaternion->at(2).number(),
                 quaternion->at(3).number());
    if (!(std::abs(q.norm() - 1) <= tolerance::quaternion_norm)) quaternion->refuse(allowed);
    pose = Pose::from(q, pose.translation);
  }
  require_valid_pose(pose, json.pointer());
  return pose;
}

void require_valid_pose(const Pose& pose, std::string_view where) {
  try {
    require_valid(pose, {});
  } catch (const std::invalid_argument& error) {
    std::string_view reason = error.what();
    if (constexpr std::string_view nameless = ": "; reason.starts_with(nameless)) reason.remove_prefix(nameless.size());
    throw InputError(where, reason);
  }
}

void write_shape(JsonWriter& out, const Shape& shape) {
  out.begin_object().member("kind", name(shape.kind()));
  if (shape.rounding() > 0) out.member("rounding", shape.rounding());
  json_kinds[static_cast<std::size_t>(shape.kind())].write(out, shape);
  out.end_object();
}

void write_pose(JsonWriter& out, const Pose& pose) {
  out.begin_object().member("t", pose.translation).key("R").begin_array();
  for (Eigen::Index row = 0; row < 3; ++row) out.value(Vec3(pose.rotation.row(row)));
  out.end_array().end_object();
}

}  // namespace tandem
