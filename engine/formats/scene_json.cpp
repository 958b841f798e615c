// Scenes as JSON (docs/scene-format.md).
#include "formats/scene_json.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

#include "formats/input_limits.h"
#include "scene/tolerances.h"

namespace tandem {
namespace {

using ShapeIds = std::map<std::string, ShapeId, std::less<>>;

BodyOptions read_body(const JsonRef& json, const ShapeIds& shapes) {
  json.require_keys(
      {"shape", "pose", "velocity", "angular_velocity", "density", "static", "sensor", "continuous", "group", "mask"});
  BodyOptions body;
  const JsonRef shape = json.at("shape");
  const auto found = shapes.find(shape.text());
  if (found == shapes.end()) shape.refuse("a name in /shapes");
  body.shape = found->second;
  if (const auto pose = json.find("pose")) body.pose = read_pose(*pose);
  if (const auto velocity = json.find("velocity")) body.velocity = velocity->vec3_up_to(limits::fastest);
  if (const auto velocity = json.find("angular_velocity"))
    body.angular_velocity = velocity->vec3_up_to(limits::fastest);
  const auto density = json.find("density"), is_static = json.find("static");
  if (density && is_static) json.refuse("both density and static", "one of them");
  if (density) {
    body.density = density->number_above(0);
    if (body.density > limits::densest) density->refuse(limits::density_range);
  }
  if (is_static) body.is_static = is_static->flag();
  if (const auto sensor = json.find("sensor")) body.is_sensor = sensor->flag();
  if (const auto continuous = json.find("continuous")) body.continuous = continuous->flag();
  constexpr std::uint32_t all = 0xffffffffu;
  if (const auto group = json.find("group")) body.group = group->whole(all);
  if (const auto mask = json.find("mask")) body.mask = mask->whole(all);
  return body;
}

void require_readable(const std::string& field, double value, bool allowed, const char* range) {
  if (allowed) return;
  std::ostringstream message;
  message << "scene: " << field << " is " << value << ", allowed in a file: " << range;
  throw std::invalid_argument(message.str());
}

void require_readable(const std::string& field, const Vec3& v) {
  for (int i = 0; i < 3; ++i)
    require_readable(field + "[" + std::to_string(i) + "]", v[i], std::abs(v[i]) <= limits::fastest,
                     limits::component_range);
}

/// Throws unless the written scene could be read again.
void require_readable(const Scene& scene) {
  require_readable("gravity", scene.gravity);
  require_readable("dt", scene.dt, scene.dt > 0 && scene.dt <= tolerance::longest_time_step,
                   tolerance::time_step_range);
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!scene.alive(i)) continue;
    const std::string body = "body " + std::to_string(i) + ": ";
    require_readable(body + "velocity", scene.velocities()[i]);
    require_readable(body + "angular_velocity", scene.angular_velocities()[i]);
    const double density = scene.densities()[i];
    require_readable(body + "density", density, scene.is_static()[i] || density <= limits::densest,
                     limits::density_range);
  }
}

}  // namespace

Scene read_scene(const JsonRef& json, ShapeReader& shape_reader) {
  json.require_keys({"name", "gravity", "dt", "request", "shapes", "bodies"});
  Scene scene;
  if (const auto text = json.find("name")) scene.name = text->text();
  if (const auto gravity = json.find("gravity")) scene.gravity = gravity->vec3_up_to(limits::fastest);
  if (const auto dt = json.find("dt")) {
    scene.dt = dt->number_above(0);
    if (scene.dt > tolerance::longest_time_step) dt->refuse(tolerance::time_step_range);
  }
  if (const auto request = json.find("request")) {
    const auto known = by_name(request->text(), requests);
    if (!known) request->refuse("collide, distance, contacts");
    scene.request = *known;
  }
  ShapeIds ids;
  if (const auto shapes = json.find("shapes")) {
    if (!shapes->value().is_object()) shapes->refuse("an object of shapes by name");
    for (const auto& [key, value] : shapes->value().get_ref<const Json::object_t&>()) {
      const JsonRef shape = shapes->member(key, value);
      ids.emplace(key, scene.add_shape(shape_reader.read(shape), key));
    }
  }
  if (const auto bodies = json.find("bodies")) {
    bodies->require_array("an array of bodies");
    for (std::size_t i = 0; i < bodies->size(); ++i) {
      const JsonRef body = bodies->at(i);
      const BodyOptions options = read_body(body, ids);
      try {
        scene.add_body(options);
      } catch (const std::invalid_argument& error) {
        body.refuse(error.what(), {});
      }
    }
  }
  return scene;
}

void write_scene(JsonWriter& out, const Scene& scene) {
  require_readable(scene);
  out.begin_object();
  out.new_line(" ").member("name", std::string_view(scene.name));
  out.new_line(" ").member("gravity", scene.gravity);
  out.new_line(" ").member("dt", scene.dt);
  out.new_line(" ").member("request", name(scene.request));
  std::vector<std::string> names;
  std::set<std::string> taken;
  out.new_line(" ").key("shapes").begin_object();
  for (std::size_t i = 0; i < scene.shapes().size(); ++i) {
    if (!scene.has_shape(static_cast<std::uint32_t>(i))) {
      names.emplace_back();
      continue;
    }
    std::string unique(scene.shape_name(static_cast<std::uint32_t>(i)));
    for (std::size_t n = i; unique.empty() || taken.contains(unique); ++n) unique = "shape" + std::to_string(n);
    taken.insert(unique);
    names.push_back(unique);
    out.new_line("  ").key(unique);
    write_shape(out, scene.shapes()[i]);
  }
  out.new_line(" ").end_object();
  out.new_line(" ").key("bodies").begin_array();
  const BodyOptions defaults;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!scene.alive(i)) continue;
    out.new_line("  ").begin_object().member("shape", std::string_view(names[scene.shape_indices()[i]]));
    out.key("pose");
    write_pose(out, scene.poses()[i]);
    const Vec3& velocity = scene.velocities()[i];
    const Vec3& angular_velocity = scene.angular_velocities()[i];
    if (!velocity.isZero(0)) out.member("velocity", velocity);
    if (!angular_velocity.isZero(0)) out.member("angular_velocity", angular_velocity);
    if (scene.is_static()[i])
      out.member("static", true);
    else
      out.member("density", scene.densities()[i]);
    if (scene.is_sensor()[i]) out.member("sensor", true);
    if (scene.continuous()[i]) out.member("continuous", true);
    if (scene.groups()[i] != defaults.group) out.member("group", scene.groups()[i]);
    if (scene.masks()[i] != defaults.mask) out.member("mask", scene.masks()[i]);
    out.end_object();
  }
  out.new_line(" ").end_array().new_line().end_object();
}

}  // namespace tandem
