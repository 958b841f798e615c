// Reads the triangles of an STL file, text or binary.
#include <array>
#include <string>

#include "formats/binary_numbers.h"
#include "formats/growing_mesh.h"
#include "formats/mesh_readers.h"
#include "formats/words.h"

namespace tandem {
namespace {

Mesh read_ascii_stl(const std::string& file, std::string_view text) {
  Mesh mesh;
  Welder welder(mesh);
  Words words(file, text);
  const auto fail = [&](std::string_view found, std::string_view allowed) { words.fail(found, allowed); };
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word != "solid") words.fail(word, "'solid'");
    words.next_line();  // the rest of this line is the solid's name
    for (word = words.next(); word == "facet"; word = words.next()) {
      words.expect("normal");
      for (int i = 0; i < 3; ++i) words.next();  // the normal is often wrong; the order of the corners gives it
      words.expect("outer");
      words.expect("loop");
      std::array<std::uint32_t, 3> triangle;
      for (std::uint32_t& corner : triangle) {
        words.expect("vertex");
        Vec3 v;
        for (double& x : v) x = words.coordinate();
        corner = welder.add(v, fail);
      }
      words.expect("endloop");
      words.expect("endfacet");
      add_triangle(mesh, triangle, fail);
    }
    if (word != "endsolid") words.fail(word, "'facet' or 'endsolid'");
    words.next_line();
  }
  if (mesh.triangles.empty()) throw InputError(file, "no facets", "one or more");
  return mesh;
}

constexpr std::size_t stl_header = 80, stl_start = 84, stl_facet = 50;

Mesh read_binary_stl(const std::string& file, std::string_view data) {
  const auto fail = [&](std::size_t byte, std::string_view found, std::string_view allowed) {
    throw InputError(file + ": byte " + std::to_string(byte), found, allowed);
  };
  const std::uint32_t facets = little_endian<std::uint32_t>(data.data() + stl_header);
  const std::size_t needed = stl_start + stl_facet * std::size_t{facets};
  if (facets == 0) fail(stl_header, "0 facets", "one or more");
  if (data.size() < needed)
    fail(data.size(), "end of file", std::to_string(needed) + " bytes for " + std::to_string(facets) + " facets");
  Mesh mesh;
  Welder welder(mesh);
  mesh.triangles.resize(facets);
  for (std::size_t i = 0; i < facets; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = stl_start + stl_facet * i + 12 + 12 * k;  // after the facet's normal
      Vec3 v;
      for (std::size_t axis = 0; axis < 3; ++axis)
        v[static_cast<Eigen::Index>(axis)] = little_endian<float>(data.data() + at + 4 * axis);
      if (!v.allFinite()) fail(at, "a coordinate that is not finite", "finite numbers");
      mesh.triangles[i][k] = welder.add(v, [&](auto found, auto allowed) { fail(at, found, allowed); });
    }
  }
  return mesh;
}

}  // namespace

Mesh read_stl(const std::string& file, std::string_view data) {
  // Binary files may begin with "solid" too; their length shows the difference.
  const bool long_enough = data.size() >= stl_start;
  const bool fits =
      long_enough &&
      data.size() == stl_start + stl_facet * std::size_t{little_endian<std::uint32_t>(data.data() + stl_header)};
  const std::string_view text = without_byte_order_mark(data);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const bool says_solid = first != std::string_view::npos && text.substr(first, 5) == "solid";
  if (!fits && says_solid) return read_ascii_stl(file, text);
  if (!long_enough)
    throw InputError(file + ": byte " + std::to_string(data.size()), "end of file",
                     "'solid' or a binary STL's 84 bytes and more");
  return read_binary_stl(file, data);
}

}  // namespace tandem
