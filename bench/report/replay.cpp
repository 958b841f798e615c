// Packs a recording for the page's replay: quantised, delta-coded, compressed.
#include "replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <set>
#include <vector>

#include "encode.h"
#include "formats/record_file.h"
#include "formats/text_file.h"
#include "results.h"
#include "shapes/hull.h"
#include "shapes/shape_insides.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::bench {
namespace {

using nlohmann::json;

constexpr std::size_t channels = 6;  // of a pose: translation, rotation

/// The bounds of a quantised value; `unit` is one step.
struct Range {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  void add(double x) { lo = std::min(lo, x), hi = std::max(hi, x); }
  double unit() const { return hi > lo ? (hi - lo) / 65535 : 1; }
  std::uint16_t operator()(double x) const {
    return static_cast<std::uint16_t>(std::lround(std::clamp((x - lo) / unit(), 0.0, 65535.0)));
  }
  json to_json() const { return lo <= hi ? json{lo, unit()} : json{0, 1}; }
};

/// The smallest three components of the unit quaternion with 15 bits each; the index of the omitted one is in the top
/// bits of the first two.
std::array<std::uint16_t, 3> quantised(const Mat3& rotation) {
  Quat q(rotation);
  q.normalize();
  const std::array<double, 4> c = {q.w(), q.x(), q.y(), q.z()};
  std::size_t largest = 0;
  for (std::size_t k = 1; k < 4; ++k)
    if (std::abs(c[k]) > std::abs(c[largest])) largest = k;
  const double sign = c[largest] < 0 ? -1 : 1;
  std::array<std::uint16_t, 3> out{};
  for (std::size_t k = 0, to = 0; k < 4; ++k)
    if (k != largest)
      out[to++] = static_cast<std::uint16_t>(std::lround((sign * c[k] * std::numbers::sqrt2 + 1) * 0.5 * 32767));
  out[0] = static_cast<std::uint16_t>(out[0] | (largest & 1) << 15);
  out[1] = static_cast<std::uint16_t>(out[1] | (largest >> 1) << 15);
  return out;
}

/// The octahedral map of a unit vector to two bytes (Cigolle et al., "A Survey of Efficient Representations for
/// Independent Unit Vectors", 2014).
std::array<std::uint8_t, 2> octahedral(const float (&n)[3]) {
  const double sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
  if (!(sum > 0)) return {128, 128};
  double x = n[0] / sum, y = n[1] / sum;
  if (n[2] < 0) {
    const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
    y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
    x = folded;
  }
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround((v + 1) * 0.5 * 255)); };
  return {byte(x), byte(y)};
}

/// Appends numbers as a plane of low bytes and one of high bytes, which compress better than interleaved ones.
void put_planes(std::string& out, const std::vector<std::uint16_t>& values) {
  for (const unsigned shift : {0u, 8u})
    for (const std::uint16_t v : values) out += static_cast<char>(v >> shift);
}

/// Zigzag code: small differences of either sign become small numbers.
std::uint16_t zigzag(std::uint16_t difference) {
  const auto d = static_cast<std::int16_t>(difference);
  return static_cast<std::uint16_t>(static_cast<std::uint16_t>(d) << 1 ^ static_cast<std::uint16_t>(d >> 15));
}

void put_u32(std::string& out, std::uint32_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift);
}

/// The quantised data of a contact in a frame.
struct Mark {
  std::uint32_t a, b;
  std::array<std::uint16_t, 6> values;  ///< point, depth, normal
};

struct Frame {
  std::uint64_t step = 0;
  std::vector<std::uint16_t> poses;  ///< [channel][body]
  std::vector<Mark> contacts;
};

/// The ranges of the whole recording, and its moving bodies.
struct Survey {
  std::array<Range, 3> place, point;
  Range depth;
  std::vector<std::uint32_t> moving;
  std::size_t steps = 0;
};

Survey survey(const std::filesystem::path& path) {
  Survey out;
  RecordReader reader(path);
  for (RecordedStep step; reader.next(step); ++out.steps) {
    if (out.steps == 0)
      for (const auto& [index, pose] : step.poses) out.moving.push_back(index);
    if (step.poses.size() != out.moving.size())
      throw InputError(fmt::format("{}: step {}", path.string(), step.step),
                       fmt::format("{} moving bodies", step.poses.size()),
                       fmt::format("{} as in the first step", out.moving.size()));
    for (std::size_t i = 0; i < step.poses.size(); ++i)
      if (step.poses[i].first != out.moving[i])
        throw InputError(fmt::format("{}: step {}", path.string(), step.step),
                         fmt::format("body {}", step.poses[i].first),
                         fmt::format("body {} as in the first step", out.moving[i]));
    for (const auto& [index, pose] : step.poses)
      for (std::size_t k = 0; k < 3; ++k) out.place[k].add(pose.translation[static_cast<Eigen::Index>(k)]);
    for (const RecordedContact& contact : step.contacts) {
      if (!(contact.depth >= 0)) continue;
      for (std::size_t k = 0; k < 3; ++k) out.point[k].add(static_cast<double>(contact.point[k]));
      out.depth.add(static_cast<double>(contact.depth));
    }
  }
  if (out.steps == 0) throw InputError(path.string(), "a record without a step", "from 1");
  return out;
}

Frame frame_of(const RecordedStep& step, const Survey& about) {
  Frame frame{step.step, std::vector<std::uint16_t>(channels * step.poses.size()), {}};
  for (std::size_t i = 0; i < step.poses.size(); ++i) {
    const Pose& pose = step.poses[i].second;
    const auto rotation = quantised(pose.rotation);
    for (std::size_t k = 0; k < 3; ++k) {
      frame.poses[k * step.poses.size() + i] = about.place[k](pose.translation[static_cast<Eigen::Index>(k)]);
      frame.poses[(3 + k) * step.poses.size() + i] = rotation[k];
    }
  }
  for (const RecordedContact& c : step.contacts) {
    if (!(c.depth >= 0)) continue;
    const auto normal = octahedral(c.normal);
    frame.contacts.push_back(
        {c.a,
         c.b,
         {about.point[0](static_cast<double>(c.point[0])), about.point[1](static_cast<double>(c.point[1])),
          about.point[2](static_cast<double>(c.point[2])), about.depth(static_cast<double>(c.depth)), normal[0],
          normal[1]}});
  }
  return frame;
}

/// Every value as the difference from the linear extrapolation of the two frames before.
std::string packed_poses(const std::vector<const Frame*>& frames) {
  std::string out;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    std::vector<std::uint16_t> residuals = frames[f]->poses;
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const int one = f > 0 ? frames[f - 1]->poses[i] : 0, two = f > 1 ? frames[f - 2]->poses[i] : one;
      residuals[i] = zigzag(static_cast<std::uint16_t>(residuals[i] - (2 * one - two)));
    }
    put_planes(out, residuals);
  }
  return deflated(out);
}

/// A frame: the number of contacts, then a and b as differences from the contact before, then the values as differences
/// from the contact of the same pair and rank in the frame before, where there is one.
std::string packed_contacts(const std::vector<const Frame*>& frames) {
  std::string out;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::vector<Mark>& now = frames[f]->contacts;
    put_u32(out, static_cast<std::uint32_t>(now.size()));
    std::array<std::vector<std::uint16_t>, 8> columns;
    const std::vector<Mark> none;
    const std::vector<Mark>& before = f > 0 ? frames[f - 1]->contacts : none;
    std::size_t old = 0;
    std::uint32_t a = 0, b = 0;
    for (const Mark& mark : now) {
      columns[0].push_back(zigzag(static_cast<std::uint16_t>(mark.a - a)));
      columns[1].push_back(zigzag(static_cast<std::uint16_t>(mark.b - b)));
      a = mark.a, b = mark.b;
      while (old < before.size() && std::pair(before[old].a, before[old].b) < std::pair(a, b)) ++old;
      const bool known = old < before.size() && before[old].a == a && before[old].b == b;
      for (std::size_t k = 0; k < mark.values.size(); ++k)
        columns[2 + k].push_back(
            zigzag(static_cast<std::uint16_t>(mark.values[k] - (known ? before[old].values[k] : 0))));
      old += known;
    }
    for (const auto& column : columns) put_planes(out, column);
  }
  return deflated(out);
}

json hull_mesh(const Hull& hull) {
  json vertices = json::array(), triangles = json::array();
  for (const Vec3& v : hull.vertices)
    for (const double x : v) vertices.push_back(static_cast<float>(x));
  for (const Hull::Face& face : hull.faces)
    for (std::uint32_t k = 2; k < face.count; ++k)
      for (const std::uint32_t corner : {0u, k - 1, k}) triangles.push_back(hull.loop[face.first + corner]);
  return {{"vertices", vertices}, {"triangles", triangles}};
}

json drawn(const Shape& shape) {
  json out{{"kind", name(shape.kind())}};
  const auto list = [](const Vec3& v) { return json{v.x(), v.y(), v.z()}; };
  switch (shape.kind()) {
    case ShapeKind::sphere:
      out["radius"] = shape.radius();
      break;
    case ShapeKind::box:
      out["size"] = list(2 * shape.half_size());
      break;
    case ShapeKind::capsule:
    case ShapeKind::cylinder:
    case ShapeKind::cone:
      out["radius"] = shape.radius();
      out["length"] = shape.length();
      break;
    case ShapeKind::ellipsoid:
      out["radii"] = list(shape.radii());
      break;
    case ShapeKind::halfspace:
    case ShapeKind::plane:
      out["normal"] = list(shape.normal());
      out["offset"] = shape.offset();
      break;
    case ShapeKind::convex:
    case ShapeKind::triangle:
      out.update(hull_mesh(hull_of(shape)));
      break;
    case ShapeKind::mesh: {
      json vertices = json::array(), triangles = json::array();
      for (const Vec3& v : shape.vertices())
        for (const double x : v) vertices.push_back(static_cast<float>(x));
      for (const auto& t : shape.triangles())
        for (const std::uint32_t i : t) triangles.push_back(i);
      out["vertices"] = vertices;
      out["triangles"] = triangles;
      out["smooth"] = true;
      break;
    }
    case ShapeKind::voxels:  // drawn as the box around them
      out["kind"] = "box";
      out["size"] = list(shape.bounds(Pose{}).hi - shape.bounds(Pose{}).lo);
  }
  return out;
}

/// The cost of detection for each body at some of the steps, measured by running detection again.
class Costs {
 public:
  explicit Costs(const Scene& scene) : scene_(scene), margin_(recommended_margin(scene)) {
    PipelineOptions options;
    options.executor = ExecutorKind::sequential;
    options.threads = 1;
    options.answer.request = scene.request;
    if (scene.request == Request::contacts) options.answer.margin = margin_;
    options.answer.contact_hash = true;
    options.predicate = [this](std::span<Pair> pairs) {
      candidates_.insert(candidates_.end(), pairs.begin(), pairs.end());
      return pairs.size();
    };
    pipeline_ = std::make_unique<Pipeline>(std::move(options));
  }

  void measure(const RecordedStep& step, std::size_t frame) {
    for (const auto& [index, pose] : step.poses) scene_.set_pose(scene_.id(index), pose);
    candidates_.clear();
    equal_ += pipeline_->step(scene_).contact_hash == step.contact_hash;
    // As the pipeline's: contacts of meshes without the bounds that only users of a single pair need.
    NarrowPhaseOptions options;
    options.mesh_gaps = options.mesh_bounds = false;
    if (scene_.request == Request::contacts) options.margin = margin_;
    const NarrowPhase narrow(options);
    std::vector<std::uint16_t> count(scene_.indices());
    std::vector<double> ns(scene_.indices());
    std::vector<Contact> contacts;
    for (const Pair& pair : candidates_) {
      contacts.clear();
      const auto begin = std::chrono::steady_clock::now();
      narrow.solve(scene_.shape_of(pair.a), scene_.poses()[pair.a], scene_.shape_of(pair.b), scene_.poses()[pair.b],
                   scene_.request, &contacts);
      const double time = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
      for (const std::uint32_t body : {pair.a, pair.b}) {
        count[body] = static_cast<std::uint16_t>(std::min(count[body] + 1, 65535));
        ns[body] += time;
      }
    }
    std::vector<std::uint16_t> code;
    for (const double t : ns) code.push_back(static_cast<std::uint16_t>(std::lround(2048 * std::log2(1 + t))));
    put_planes(bytes_, count);
    put_planes(bytes_, code);
    frames_.push_back(frame);
  }

  std::string packed() const { return deflated(bytes_); }
  json about() const { return {{"frames", frames_}, {"equal_hashes", equal_}}; }

 private:
  Scene scene_;
  double margin_;
  std::vector<Pair> candidates_;
  std::unique_ptr<Pipeline> pipeline_;
  std::string bytes_;
  std::vector<std::size_t> frames_;
  std::size_t equal_ = 0;
};

/// The bodies that never move, and their poses.
json still_bodies(const Scene& scene, const Survey& about) {
  json still = json::array();
  std::set<std::uint32_t> moving(about.moving.begin(), about.moving.end());
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (moving.count(i) != 0) continue;
    const Pose& pose = scene.poses()[i];
    const Quat q(pose.rotation);
    still.push_back({{"body", i},
                     {"t", {pose.translation.x(), pose.translation.y(), pose.translation.z()}},
                     {"q", {q.x(), q.y(), q.z(), q.w()}}});
  }
  return still;
}

/// Packs every frame, or every second, fourth ... if all take more than `most_bytes`; returns the frames that are kept,
/// and sets the stride.
std::vector<const Frame*> pack(const std::vector<Frame>& frames, std::size_t most_bytes, Replay& out,
                               std::size_t& stride) {
  stride = 1;
  std::vector<const Frame*> kept;
  do {
    kept.clear();
    for (std::size_t f = 0; f < frames.size(); f += stride) kept.push_back(&frames[f]);
    out.poses = packed_poses(kept);
    out.contacts = packed_contacts(kept);
    stride *= 2;
  } while (out.size() > most_bytes && kept.size() > 2);
  stride /= 2;

  return kept;
}

}  // namespace

Replay read_replay(const std::filesystem::path& path, std::size_t most_frames, std::size_t most_bytes,
                   const std::function<void(std::size_t done, std::size_t of)>& done) {
  const Survey about = survey(path);
  const std::size_t every = (about.steps + most_frames - 1) / most_frames;
  const std::size_t count = (about.steps + every - 1) / every;
  constexpr std::size_t most_costs = 24;
  const std::size_t cost_every = (count + most_costs - 1) / most_costs;

  RecordReader reader(path);
  const Scene& scene = reader.scene();
  Costs costs(scene);
  std::vector<Frame> frames;
  std::vector<std::string> hashes;
  RecordedStep step;
  for (std::size_t i = 0; reader.next(step); ++i) {
    hashes.push_back(hex(step.contact_hash));
    done(i, about.steps);
    if (i % every != 0) continue;
    if (frames.size() % cost_every == 0) costs.measure(step, frames.size());
    frames.push_back(frame_of(step, about));
  }

  Replay out;
  out.costs = costs.packed();
  std::size_t stride = 1;
  const std::vector<const Frame*> kept = pack(frames, most_bytes, out, stride);

  json shapes = json::array(), steps = json::array();
  for (const Shape& shape : scene.shapes()) shapes.push_back(drawn(shape));
  for (const Frame* frame : kept) steps.push_back(frame->step);
  json place = json::array(), point = json::array();
  for (std::size_t k = 0; k < 3; ++k)
    place.push_back(about.place[k].to_json()), point.push_back(about.point[k].to_json());
  json names = json::array();
  for (std::uint32_t k = 0; k < scene.shapes().size(); ++k) names.push_back(scene.shape_name(k));
  json cost = costs.about();
  // A cost belongs to the kept frame nearest to the one it was measured at.
  for (json& frame : cost["frames"]) frame = std::min(frame.get<std::size_t>() / stride, kept.size() - 1);
  out.about = {{"file", path.string()},
               {"name", scene.name},
               {"bodies", scene.indices()},
               {"dt", scene.dt},
               {"recorded_steps", about.steps},
               {"steps", steps},
               {"hashes", hashes},
               {"shapes", shapes},
               {"shape_names", names},
               {"shape_of", scene.shape_indices()},
               {"moving", about.moving},
               {"still", still_bodies(scene, about)},
               {"place", place},
               {"point", point},
               {"depth", about.depth.to_json()},
               {"cost", cost}};
  return out;
}

}  // namespace tandem::bench
