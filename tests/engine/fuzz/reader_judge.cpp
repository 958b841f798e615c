// Checks readers of files on arbitrary bytes.
#include "reader_judge.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "formats/json_writer.h"
#include "formats/output_file.h"
#include "formats/pair_record.h"
#include "formats/record_file.h"
#include "formats/scene_json.h"
#include "formats/text_file.h"
#include "inputs.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/formats/octomap_file.h"
#include "tandem/formats/scene_file.h"
#include "temporary_folder.h"

namespace tandem::test {
namespace {

constexpr std::size_t refusal_bytes = 300;  // the documented limit
// Files of the fuzz targets are small: the readers' limit of a line for them.
constexpr std::uint64_t line_bytes = 2048;

/// An accepted input that is read differently when written again.
struct Wrong {
  std::string what;
};

void require(bool condition, std::string_view what) {
  if (!condition) throw Wrong{std::string(what)};
}

/// An error message must be one line of valid UTF-8 under 300 characters.
void check_refusal(const std::string& what) {
  require(!what.empty() && what.size() < refusal_bytes,
          "a refusal of " + std::to_string(what.size()) + " bytes: " + what);
  require(std::none_of(what.begin(), what.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }),
          "a refusal with a control character: " + what);
  try {
    (void)Json(what).dump();
  } catch (const Json::exception&) {
    throw Wrong{"a refusal that is not UTF-8: " + what};
  }
}

/// An accepted input must be accepted again.
template <typename Read>
auto read_again(Read&& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw Wrong{std::string("refused when written again: ") + error.what()};
  }
}

const TemporaryFolder& folder() {
  static const TemporaryFolder own;
  return own;
}

/// A new file with these bytes. New, since some file systems wait for the disk when a file is overwritten.
std::filesystem::path file_of(std::string_view name, std::string_view bytes) {
  std::filesystem::remove(folder() / name);
  return folder().write(name, bytes);
}

std::string written(const std::function<void(JsonWriter&)>& write) {
  JsonWriter out;
  write(out);
  return out.text();
}

std::string shape_text(const Shape& shape) {
  return written([&](JsonWriter& out) { write_shape(out, shape); });
}

void check_shape(const Shape& shape) {
  const std::string once = shape_text(shape);
  const std::string twice = read_again([&] {
    const Json json = parse_json(once);
    ShapeReader reader({folder().path()});
    return shape_text(reader.read(JsonRef(json)));
  });
  require(twice == once, "a shape that reads back as another: " + once + " and " + twice);
}

void check_pose(const Pose& pose) {
  const std::string once = written([&](JsonWriter& out) { write_pose(out, pose); });
  const Pose again = read_again([&] {
    const Json json = parse_json(once);
    return read_pose(JsonRef(json));
  });
  require(again.translation == pose.translation && again.rotation == pose.rotation,
          "a pose that reads back as another: " + once);
}

/// As `tandem query` reads records: line by line, up to the shapes.
void judge_pair_records(std::string_view bytes) {
  InputFile file(file_of("records.jsonl", bytes));
  ShapeReader shapes({folder().path()});
  std::string line;
  std::size_t number = 0;
  for (InputFile::Line found; (found = file.line(line, line_bytes)) != InputFile::Line::none;) {
    ++number;
    if (found == InputFile::Line::too_long) continue;
    try {
      const Json json = parse_json(line);
      const PairRecord record = read_pair_record(json, shapes);
      for (const PlacedShape* placed : {&record.a, &record.b}) {
        check_shape(placed->shape);
        check_pose(placed->pose);
      }
      (void)record.id.dump();
    } catch (const InputError& error) {
      check_refusal(error.what());
      const AnsweredLine answered = answer_line(line, number, shapes, {});
      require(!answered.ok && !answered.is_record, "an answer to a bad record");
      const Json answer = parse_json(answered.text);
      require(answer.at("line") == number && answer.at("status") == "error", "another answer to a bad record");
      check_refusal(answer.at("error").get<std::string>());
    }
  }
}

std::string scene_text(const Scene& scene) {
  return written([&](JsonWriter& out) { write_scene(out, scene); });
}

void judge_scene(std::string_view bytes) {
  const Scene scene = read_scene_file(file_of("scene.json", bytes));
  const std::string once = scene_text(scene);
  const std::string twice = read_again([&] { return scene_text(read_scene_file(file_of("again.json", once))); });
  require(twice == once, "a scene that reads back as another");
}

void judge_mesh(std::string_view bytes, std::string_view extension) {
  const Mesh mesh = read_mesh_file(file_of("mesh" + std::string(extension), bytes));
  std::string obj;
  for (const Vec3& v : mesh.vertices) {
    obj += 'v';
    for (const double x : v) obj += ' ' + written([&](JsonWriter& out) { out.value(x); });
    obj += '\n';
  }
  for (const auto& [i, j, k] : mesh.triangles) {
    require(std::max({i, j, k}) < mesh.vertices.size(), "a triangle of a vertex that there is not");
    obj += "f " + std::to_string(i + 1) + ' ' + std::to_string(j + 1) + ' ' + std::to_string(k + 1) + '\n';
  }
  const Mesh again = read_again([&] { return read_mesh_file(file_of("again.obj", obj)); });
  require(again.vertices == mesh.vertices && again.triangles == mesh.triangles, "a mesh that reads back as another");
  // As a scene reads it, where the mesh itself may be refused.
  const Json json = parse_json(R"({"kind":"mesh","file":"again.obj"})");
  ShapeReader reader({folder().path()});
  check_shape(reader.read(JsonRef(json)));
}

/// Cells within a node of an octree, as octomap's .ot files have them: log odds and a bit for each child.
void write_octree(std::string& out, const VoxelCell& node, std::span<const VoxelCell> cells) {
  const bool is_leaf = cells.size() == 1 && cells[0] == node;
  const float odds = is_leaf ? 1.0f : 0.0f;
  const auto bits = std::bit_cast<std::uint32_t>(odds);
  for (unsigned k = 0; k < 4; ++k) out += static_cast<char>(bits >> 8 * k & 255u);
  const std::size_t mask = out.size();
  out += '\0';
  if (is_leaf) return;
  require(node.level > 0, "cells that overlap");
  for (unsigned i = 0; i < 8; ++i) {
    VoxelCell child{node.corner, static_cast<std::uint8_t>(node.level - 1)};
    for (std::size_t k = 0; k < 3; ++k) child.corner[k] += static_cast<std::int32_t>(i >> k & 1u) << child.level;
    std::vector<VoxelCell> within;
    for (const VoxelCell& cell : cells) {
      bool is_in = cell.level <= child.level;
      for (std::size_t k = 0; k < 3; ++k)
        is_in = is_in && cell.corner[k] >= child.corner[k] && cell.corner[k] < child.corner[k] + (1 << child.level);
      if (is_in) within.push_back(cell);
    }
    if (within.empty()) continue;
    out[mask] = static_cast<char>(static_cast<unsigned char>(out[mask]) | 1u << i);
    write_octree(out, child, within);
  }
}

void judge_octomap(std::string_view bytes) {
  Voxels map = read_octomap_file(file_of("map.bt", bytes));
  require(map.cell_size > 0 && map.origin == Vec3::Zero(), "a map without a resolution, or with an origin");
  if (map.cells.empty()) return;
  std::string tree = "# Octomap OcTree file\nid OcTree\nres " +
                     written([&](JsonWriter& out) { out.value(map.cell_size); }) + "\ndata\n";
  write_octree(tree, {{-32768, -32768, -32768}, 16}, map.cells);
  Voxels again = read_again([&] { return read_octomap_file(file_of("again.ot", tree)); });
  const auto key = [](const VoxelCell& cell) { return std::pair(cell.corner, cell.level); };
  for (std::vector<VoxelCell>* cells : {&map.cells, &again.cells})
    std::sort(cells->begin(), cells->end(),
              [&](const VoxelCell& x, const VoxelCell& y) { return key(x) < key(y); });
  require(again.cells == map.cells && again.cell_size == map.cell_size, "an octree that reads back as another");
}

/// A recording that was read, written again.
std::string written_again(RecordReader& reader) {
  Scene scene = reader.scene();
  const auto path = folder() / "written.record";
  OutputFile file("--record", path);
  RecordWriter writer(file, scene);
  for (RecordedStep step; reader.next(step);) {
    for (const auto& [index, pose] : step.poses) scene.set_pose(scene.id(index), pose);
    ContactList list;
    for (const RecordedContact& from : step.contacts) {
      Contact contact;
      for (Eigen::Index k = 0; k < 3; ++k) {
        contact.point[k] = static_cast<double>(from.point[k]);
        contact.normal[k] = static_cast<double>(from.normal[k]);
      }
      contact.depth = static_cast<double>(from.depth);
      PairResult pair;
      pair.a = from.a, pair.b = from.b;
      pair.first_contact = static_cast<std::uint32_t>(list.contacts.size()), pair.contact_count = 1;
      list.pairs.push_back(pair);
      list.contacts.push_back(contact);
    }
    writer.step(step.step, step.contact_hash, scene, list);
  }
  file.commit();
  return read_file(path);
}

void judge_recording(std::string_view bytes) {
  RecordReader reader(file_of("bytes.record", bytes));
  const std::string once = written_again(reader);
  const std::string twice = read_again([&] {
    RecordReader again(file_of("again.record", once));
    return written_again(again);
  });
  const auto [at, other] = std::mismatch(once.begin(), once.end(), twice.begin(), twice.end());
  require(twice == once, "a recording that reads back as another from byte " + std::to_string(at - once.begin()) +
                             " on: " + on_one_line({at, once.end()}) + " and " + on_one_line({other, twice.end()}));
}

void judge_results(std::string_view bytes) {
  const auto path = file_of("results.json", bytes);
  const bench::Inputs inputs = bench::read_inputs({path});
  for (Json result : inputs.results) {
    if (result.contains("pictures")) continue;  // without the rows that a file has
    const auto again = read_again([&] { return bench::read_inputs({file_of("results.json", result.dump())}); });
    require(again.results.size() == 1 && again.results[0] == result, "results that read back as others");
  }
  for (const Json& run : inputs.runs) {
    std::string lines;
    for (const Json& step : run.at("steps")) lines += step.dump() + '\n';
    if (!lines.starts_with(R"({"step":)")) continue;  // another member came first in a line
    const auto again = read_again([&] { return bench::read_inputs({file_of("results.json", lines)}); });
    require(again.runs == inputs.runs, "a run that reads back as another");
  }
  (void)inputs.timelines.dump();
}

void judge(std::string_view reader, std::string_view bytes) {
  if (reader == "pair_record") return judge_pair_records(bytes);
  if (reader == "scene") return judge_scene(bytes);
  for (const std::string_view extension : {".obj", ".stl", ".ply", ".off", ".gltf", ".glb"})
    if (reader == extension.substr(1)) return judge_mesh(bytes, extension);
  if (reader == "octomap") return judge_octomap(bytes);
  if (reader == "recording") return judge_recording(bytes);
  if (reader == "results") return judge_results(bytes);
  throw Wrong{"no such reader"};
}

}  // namespace

std::string judge_reader(std::string_view reader, std::string_view bytes) {
  try {
    try {
      judge(reader, bytes);
    } catch (const InputError& error) {
      check_refusal(error.what());
    }
  } catch (const Wrong& wrong) {
    return wrong.what;
  } catch (const std::exception& error) {
    return std::string("another exception: ") + error.what();
  }
  return {};
}

}  // namespace tandem::test
