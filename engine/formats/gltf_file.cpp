// Reads the triangles of a glTF or GLB file.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/binary_numbers.h"
#include "formats/gltf_buffers.h"
#include "formats/growing_mesh.h"
#include "formats/mesh_readers.h"
#include "formats/words.h"

// Khronos, glTF 2.0 specification: a JSON document of nodes, meshes and accessors, with their numbers in buffers; GLB
// is both in one file.

namespace tandem {
namespace {

/// An affine map p -> linear p + offset, from a node's frame to the scene's.
struct Placement {
  Mat3 linear = Mat3::Identity();
  Vec3 offset = Vec3::Zero();
};

Placement operator*(const Placement& a, const Placement& b) {
  return {a.linear * b.linear, a.linear * b.offset + a.offset};
}

template <std::size_t n>
std::array<double, n> some_numbers(const JsonRef& json) {
  const std::string allowed = std::to_string(n) + " numbers";
  json.require_array(allowed);
  if (json.size() != n) json.refuse(allowed);
  std::array<double, n> out;
  for (std::size_t i = 0; i < n; ++i) out[i] = json.at(i).number();
  return out;
}

/// A node's transform relative to its parent: `matrix` by columns, or `translation`, `rotation` (x, y, z, w) and
/// `scale`.
Placement placement_of(const JsonRef& node) {
  Placement out;
  if (const auto matrix = node.find("matrix")) {
    const std::array<double, 16> m = some_numbers<16>(*matrix);
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) matrix->refuse("0, 0, 0, 1 in its last row");
    out.linear << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
    out.offset = {m[12], m[13], m[14]};
    return out;
  }
  if (const auto rotation = node.find("rotation")) {
    const auto [x, y, z, w] = some_numbers<4>(*rotation);
    const double largest = std::max({std::abs(x), std::abs(y), std::abs(z), std::abs(w)});
    if (!(largest > 0)) rotation->refuse("a quaternion [x, y, z, w] that is not 0");
    out.linear = Quat(w / largest, x / largest, y / largest, z / largest).normalized().toRotationMatrix();
  }
  if (const auto scale = node.find("scale")) out.linear = out.linear * scale->vec3().asDiagonal();
  if (const auto translation = node.find("translation")) out.offset = translation->vec3();
  return out;
}

constexpr std::uint32_t first_of_triangles = 4, strip = 5, fan = 6;  // modes of primitives

/// A primitive of a mesh, triangles in one of the three modes.
struct Primitive {
  std::size_t place;  // in the mesh's list
  std::uint32_t mode;
  GltfNumbers points;
  std::optional<GltfNumbers> indices;

  std::uint32_t corners() const { return indices ? indices->count : points.count; }
};

struct GltfMesh {
  std::vector<Primitive> primitives;
  std::uint64_t corners = 0;
};

/// A node's mesh and where it is.
struct Use {
  std::uint32_t mesh;
  Placement placement;
};

std::uint32_t index_at(const GltfNumbers& indices, std::uint32_t i) {
  const char* at = indices.element(i);
  return indices.component == 5121   ? little_endian<std::uint8_t>(at)
         : indices.component == 5123 ? little_endian<std::uint16_t>(at)
                                     : little_endian<std::uint32_t>(at);
}

class GltfReader {
 public:
  GltfReader(const JsonRef& document, std::string_view binary, const std::filesystem::path& folder)
      : document_(document),
        scenes_(document, "scenes"),
        nodes_(document, "nodes"),
        meshes_(document, "meshes"),
        buffers_(document, binary, folder),
        meshes_read_(meshes_.size()) {}

  Mesh read() {
    require_known();
    struct Next {
      std::uint32_t node;
      Placement parent;
    };
    std::vector<Next> stack;
    const auto push = [&](const std::vector<std::uint32_t>& nodes, const Placement& parent) {
      for (std::size_t i = nodes.size(); i-- > 0;) stack.push_back({nodes[i], parent});
    };
    std::vector<bool> seen(nodes_.size());
    push(roots(), {});
    while (!stack.empty()) {
      const auto [at, parent] = stack.back();
      stack.pop_back();
      const JsonRef node = nodes_.at(at);
      if (seen[at]) node.refuse("a node in two places", "a tree");
      seen[at] = true;
      const Placement placement = parent * placement_of(node);
      if (const auto mesh = node.find("mesh")) use(node, *mesh, placement);
      if (const auto children = node.find("children")) push(places(*children), placement);
    }
    for (const Use& its : uses_)
      for (const Primitive& primitive : meshes_read_[its.mesh]->primitives)
        if (primitive.corners() > 0) add_primitive(its.mesh, primitive, its.placement);
    if (mesh_.triangles.empty()) document_.refuse("no triangles", "a scene with a mesh of triangles");
    return std::move(mesh_);
  }

 private:
  /// Refuses required extensions that could change geometry; those for colours and textures do not.
  void require_known() const {
    const JsonRef asset = document_.at("asset"), version = asset.at("version");
    if (!version.text().starts_with("2.")) version.refuse("2.0");
    const auto extensions = document_.find("extensionsRequired");
    if (!extensions) return;
    extensions->require_array("an array of names");
    for (std::size_t i = 0; i < extensions->size(); ++i) {
      const JsonRef extension = extensions->at(i);
      if (!extension.text().starts_with("KHR_materials_") && !extension.text().starts_with("KHR_texture_"))
        extension.refuse("no required extension but of materials and textures");
    }
  }

  std::vector<std::uint32_t> places(const JsonRef& list) const {
    list.require_array("an array of nodes");
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const JsonRef index = list.at(i);
      out.push_back(nodes_.place(index));
    }
    return out;
  }

  /// The root nodes of the scene; without a scene, all nodes that are no other's child.
  std::vector<std::uint32_t> roots() const {
    if (scenes_.size() > 0) {
      const auto which = document_.find("scene");
      const JsonRef scene = scenes_.at(which ? scenes_.place(*which) : 0);
      const auto nodes = scene.find("nodes");
      return nodes ? places(*nodes) : std::vector<std::uint32_t>();
    }
    std::vector<bool> is_child(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const JsonRef node = nodes_.at(i);
      if (const auto children = node.find("children"))
        for (const std::uint32_t child : places(*children)) is_child[child] = true;
    }
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < is_child.size(); ++i)
      if (!is_child[i]) out.push_back(i);
    return out;
  }

  /// Notes that a node has a mesh. Corners are counted before any is added, and apart from the triangles, since strips
  /// turn by triangles that are left out.
  void use(const JsonRef& node, const JsonRef& index, const Placement& placement) {
    if (const auto skin = node.find("skin")) skin->refuse("a skin", "nodes without a skin");
    const std::uint32_t place = meshes_.place(index);
    if (!meshes_read_[place]) meshes_read_[place] = read_mesh(place);
    corners_ += meshes_read_[place]->corners;
    primitives_ += meshes_read_[place]->primitives.size();
    if (std::max(corners_, primitives_) > limits::mesh_vertices)
      node.refuse("one more use of a mesh", "at most " + std::to_string(limits::mesh_vertices) + " corners in all");
    uses_.push_back({place, placement});
  }

  /// The triangles of a mesh. Points and lines have no surface and are skipped.
  GltfMesh read_mesh(std::uint32_t place) {
    const JsonRef mesh = meshes_.at(place), primitives = mesh.at("primitives");
    primitives.require_array("an array of primitives");
    GltfMesh out;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const JsonRef json = primitives.at(i), attributes = json.at("attributes");
      const auto mode = json.find("mode");
      Primitive primitive{i, mode ? mode->whole(fan) : first_of_triangles, {}, {}};
      const auto position = attributes.find("POSITION");
      if (primitive.mode < first_of_triangles || !position) continue;
      primitive.points = buffers_.numbers(*position, "VEC3", 3);
      if (primitive.points.component != 5126) position->refuse("positions that are no floats", "componentType 5126");
      if (const auto index = json.find("indices")) {
        primitive.indices = buffers_.numbers(*index, "SCALAR", 1);
        if (primitive.indices->component == 5126) index->refuse("indices that are floats", "whole numbers");
      }
      const std::uint32_t count = primitive.corners();
      if (primitive.mode == first_of_triangles && count % 3 != 0)
        json.refuse(std::to_string(count) + " corners of triangles", "three a triangle");
      out.primitives.push_back(primitive);
      out.corners += count;
    }
    return out;
  }

  [[noreturn]] void refuse_primitive(std::uint32_t place, std::size_t i, std::string_view found,
                                     std::string_view allowed) const {
    const JsonRef mesh = meshes_.at(place), primitives = mesh.at("primitives"), primitive = primitives.at(i);
    primitive.refuse(found, allowed);
  }

  void add_primitive(std::uint32_t place, const Primitive& primitive, const Placement& placement) {
    const auto fail = [&](std::string_view found, std::string_view allowed) {
      refuse_primitive(place, primitive.place, found, allowed);
    };
    const std::uint32_t mode = primitive.mode, count = primitive.corners();
    const GltfNumbers& points = primitive.points;
    const auto corner = [&](std::uint32_t i) {
      const std::uint32_t at = primitive.indices ? index_at(*primitive.indices, i) : i;
      if (at >= points.count) fail("vertex " + std::to_string(at), "0 up to below " + std::to_string(points.count));
      return welder_.add(placed(points.element(at), placement, fail), fail);
    };
    const bool mirrored = placement.linear.determinant() < 0;
    const auto add = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
      if (mirrored) std::swap(j, k);
      const std::uint32_t a = corner(i), b = corner(j), c = corner(k);
      // Strips turn by degenerate triangles, with two equal corners: skip these.
      if (mode != strip || (a != b && b != c && c != a)) add_triangle(mesh_, {a, b, c}, fail);
    };
    if (mode == first_of_triangles)
      for (std::uint32_t i = 0; i < count; i += 3) add(i, i + 1, i + 2);
    else
      for (std::uint32_t i = 0; i + 2 < count; ++i)
        mode == fan ? add(0, i + 1, i + 2) : add(i, i + 1 + i % 2, i + 2 - i % 2);
  }

  template <typename Fail>
  static Vec3 placed(const char* bytes, const Placement& placement, const Fail& fail) {
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<double>(little_endian<float>(bytes + 4 * axis));
    const Vec3 out = placement.linear * p + placement.offset;
    if (!out.allFinite()) fail("a coordinate that is not finite", "finite numbers");
    return out;
  }

  const JsonRef& document_;
  GltfList scenes_, nodes_, meshes_;
  GltfBuffers buffers_;
  std::vector<std::optional<GltfMesh>> meshes_read_;  // each at its first use
  std::vector<Use> uses_;
  std::uint64_t corners_ = 0, primitives_ = 0;  // of all uses
  Mesh mesh_;
  Welder welder_{mesh_};
};

/// The two chunks of a GLB file that are used; others are skipped.
struct Chunks {
  std::string_view json, binary;
};

Chunks chunks_of(const std::string& file, std::string_view bytes) {
  constexpr std::size_t header = 12, chunk_header = 8;
  constexpr std::uint32_t json_type = 0x4e4f534a, binary_type = 0x004e4942;
  const auto fail = [&](std::size_t byte, std::string_view found, std::string_view allowed) {
    throw InputError(file + ": byte " + std::to_string(byte), found, allowed);
  };
  if (bytes.size() < header) fail(bytes.size(), "end of file", "a GLB's header of 12 bytes");
  const auto version = little_endian<std::uint32_t>(bytes.data() + 4);
  if (version != 2) fail(4, "version " + std::to_string(version), "2");
  const auto length = little_endian<std::uint32_t>(bytes.data() + 8);
  if (length > bytes.size()) fail(bytes.size(), "end of file", std::to_string(length) + " bytes, as byte 8 says");
  bytes = bytes.substr(0, length);
  Chunks out;
  for (std::size_t at = header; at + chunk_header <= bytes.size();) {
    const auto size = little_endian<std::uint32_t>(bytes.data() + at);
    const auto type = little_endian<std::uint32_t>(bytes.data() + at + 4);
    if (size > bytes.size() - at - chunk_header)
      fail(at, "a chunk of " + std::to_string(size) + " bytes", "what is left in the file");
    const std::string_view chunk = bytes.substr(at + chunk_header, size);
    if (type == json_type && out.json.empty()) out.json = chunk;
    if (type == binary_type && out.binary.data() == nullptr) out.binary = chunk;
    at += chunk_header + size;
  }
  if (out.json.empty()) fail(header, "no JSON chunk", "one");
  return out;
}

}  // namespace

Mesh read_gltf(const std::string& file, std::string_view bytes, const std::filesystem::path& folder) {
  const Chunks chunks = bytes.starts_with("glTF") ? chunks_of(file, bytes) : Chunks{bytes, {}};
  try {
    const Json json = parse_json(without_byte_order_mark(chunks.json));
    const JsonRef document(json);
    return GltfReader(document, chunks.binary, folder).read();
  } catch (const InputError& error) {
    throw error.within(file);
  }
}

}  // namespace tandem
