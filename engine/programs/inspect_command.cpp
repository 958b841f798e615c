// The command `tandem inspect`: the faults of mesh files, with their places.
#include <memory>
#include <sstream>

#include "commands.h"
#include "formats/json_writer.h"
#include "option_text.h"
#include "tandem/formats/input_error.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/narrowphase/inspection.h"

namespace tandem {
namespace {

struct Options {
  std::vector<std::string> files;
  std::string most = "10";
  bool json = false;
};

// Faults as text, one a line, and as members of JSON objects.

std::string text(const Vec3& v) {
  std::ostringstream out;
  out.precision(9);
  out << '(' << v.x() << ", " << v.y() << ", " << v.z() << ')';
  return out.str();
}

std::string words(const DuplicateVertex& f) {
  return "vertex " + std::to_string(f.vertex) + " is at " + text(f.place) + " like vertex " + std::to_string(f.same_as);
}
std::string words(const DuplicateTriangle& f) {
  return "triangle " + std::to_string(f.triangle) + " has the corners of triangle " + std::to_string(f.same_as) +
         ", about " + text(f.place);
}
std::string words(const FlatTriangle& f) {
  return "triangle " + std::to_string(f.triangle) + " has no area, about " + text(f.place);
}
std::string words(const FaultyEdge& f) {
  return std::string(name(f.fault)) + " edge from vertex " + std::to_string(f.vertices[0]) + " " + text(f.ends[0]) +
         " to vertex " + std::to_string(f.vertices[1]) + " " + text(f.ends[1]) + " (triangle " +
         std::to_string(f.triangle) + "): triangles in this sense: " + std::to_string(f.forward) +
         ", in the other: " + std::to_string(f.backward);
}
std::string words(const InsideOut& f) {
  return "inside out: " + std::to_string(f.triangles) + " triangles, the first is " + std::to_string(f.triangle) +
         ", with a corner at " + text(f.place);
}
std::string words(const SelfIntersection& f) {
  return "triangles " + std::to_string(f.triangles[0]) + " and " + std::to_string(f.triangles[1]) + " cross near " +
         text(f.place);
}

void members(JsonWriter& out, const DuplicateVertex& f) {
  out.member("vertex", f.vertex).member("same_as", f.same_as).member("place", f.place);
}
void members(JsonWriter& out, const DuplicateTriangle& f) {
  out.member("triangle", f.triangle).member("same_as", f.same_as).member("place", f.place);
}
void members(JsonWriter& out, const FlatTriangle& f) { out.member("triangle", f.triangle).member("place", f.place); }
void members(JsonWriter& out, const FaultyEdge& f) {
  out.member("fault", name(f.fault))
      .key("vertices")
      .begin_array()
      .value(f.vertices[0])
      .value(f.vertices[1])
      .end_array();
  out.key("ends").begin_array().value(f.ends[0]).value(f.ends[1]).end_array();
  out.member("triangle", f.triangle).member("forward", f.forward).member("backward", f.backward);
}
void members(JsonWriter& out, const InsideOut& f) {
  out.member("triangle", f.triangle)
      .member("triangles", f.triangles)
      .member("volume", f.volume)
      .member("place", f.place);
}
void members(JsonWriter& out, const SelfIntersection& f) {
  out.key("triangles").begin_array().value(f.triangles[0]).value(f.triangles[1]).end_array().member("place", f.place);
}

template <class Take>
void each_list(const MeshInspection& found, const Take& take) {
  take("faulty_edges", "edges that do not join two triangles in opposite sense", found.faulty_edges);
  take("self_intersections", "pairs of triangles that cross", found.self_intersections);
  take("inside_out", "components that are inside out", found.inside_out);
  take("flat_triangles", "triangles without area", found.flat_triangles);
  take("duplicate_triangles", "repeated triangles", found.duplicate_triangles);
  take("duplicate_vertices", "vertices at the coordinates of others", found.duplicate_vertices);
}

std::string as_json(const std::string& file, const MeshInspection& found) {
  JsonWriter out;
  out.begin_object().member("file", file).member("vertices", found.vertices).member("triangles", found.triangles);
  out.member("components", found.components)
      .member("closed", found.closed())
      .member("clean_solid", found.is_clean_solid());
  each_list(found, [&](const char* key, const char*, const auto& list) {
    out.key(key).begin_object().member("count", list.count).key("first").begin_array();
    for (const auto& fault : list.first) {
      out.begin_object();
      members(out, fault);
      out.end_object();
    }
    out.end_array().end_object();
  });
  out.end_object();
  return out.text() + '\n';
}

std::string as_text(const std::string& file, const MeshInspection& found) {
  std::ostringstream out;
  out << file << ": triangles: " << found.triangles << ", vertices: " << found.vertices
      << ", components: " << found.components
      << (found.is_clean_solid() ? "; a clean solid"
          : found.closed()       ? "; closed"
                                 : "; not closed")
      << '\n';
  each_list(found, [&](const char*, const char* what, const auto& list) {
    if (list.count == 0) return;
    out << "  " << what << ": " << list.count << '\n';
    for (const auto& fault : list.first) out << "    " << words(fault) << '\n';
    if (list.count > list.first.size()) out << "    ... and " << list.count - list.first.size() << " more\n";
  });
  return out.str();
}

MeshInspection inspected(const std::string& file, const InspectionOptions& how) {
  const Mesh mesh = read_mesh_file(file);
  try {
    return inspect(mesh, how);
  } catch (const std::invalid_argument& error) {
    throw InputError(file, error.what());
  }
}

}  // namespace

void add_inspect_command(CLI::App& program, DescriptorBuffer& out, int& status) {
  CLI::App* command = program.add_subcommand("inspect", "list the faults of mesh files, with their places");
  const auto options = std::make_shared<Options>();
  command->add_option("FILES", options->files, "mesh files (" + std::string(mesh_extensions) + ")")->type_name("");
  command->add_flag("--json", options->json, "a JSON object a file instead of text");
  command->add_option("--most", options->most, "faults listed of each kind, 0 to 1000000")
      ->type_name("N")
      ->capture_default_str();
  command->footer(
      "Vertices with equal coordinates count as one. Crossings and areas are exact.\n"
      "Exit status: 0 done, whatever was found; 1 the work failed, 2 the request was wrong.");
  command->callback([options, &out, &status] {
    if (options->files.empty()) refuse_option("FILES", "", "mesh files, at least one");
    InspectionOptions how;
    how.most = whole_option("--most", options->most, 0, 1'000'000);
    for (const std::string& file : options->files) {
      const MeshInspection found = inspected(file, how);
      out.append(options->json ? as_json(file, found) : as_text(file, found));
    }
    status = 0;
  });
}

}  // namespace tandem
