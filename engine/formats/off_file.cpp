// Reads the triangles of an OFF file.
#include <algorithm>
#include <string>

#include "formats/growing_mesh.h"
#include "formats/mesh_readers.h"
#include "formats/words.h"

namespace tandem {
namespace {

/// The first word of the next line that is not empty; empty at the end of the text.
std::string_view first_of_next_line(Words& words) {
  while (words.next_line()) {
    const std::string_view word = words.next_of_line();
    if (!word.empty()) return word;
  }
  return {};
}

/// Skips the header's keyword, which is optional and may precede the first number without a space; letters before OFF
/// announce more numbers for a vertex: ST texture coordinates, C a colour, N a normal. Returns the first number.
std::string_view pass_keyword(Words& words) {
  const std::string_view word = words.next();
  const std::size_t off = word.find("OFF");
  if (off == std::string_view::npos) return word;
  const std::string_view before = word.substr(0, off), behind = word.substr(off + 3);
  constexpr std::string_view known[] = {"", "C", "N", "CN", "ST", "STC", "STN", "STCN"};
  if (std::find(std::begin(known), std::end(known), before) == std::end(known))
    words.fail(word, "OFF, before it ST, C and N or none");
  const std::string_view first = behind.empty() ? words.next() : behind;
  if (first == "BINARY") words.fail(first, "OFF as text");
  return first;
}

}  // namespace

Mesh read_off(const std::string& file, std::string_view text) {
  Words words(file, without_byte_order_mark(text), '#');
  const auto fail = [&](std::string_view found, std::string_view allowed) { words.fail(found, allowed); };
  const std::int64_t vertices = words.whole(pass_keyword(words)), faces = words.whole();
  if (vertices < 1 || faces < 1)
    words.fail(std::to_string(vertices) + " vertices, " + std::to_string(faces) + " faces", "one or more of each");
  Mesh mesh;
  for (std::int64_t i = 0; i < vertices; ++i) {
    Vec3 v;
    v.x() = words.coordinate(first_of_next_line(words));
    v.y() = words.coordinate(words.next_of_line());
    v.z() = words.coordinate(words.next_of_line());
    add_vertex(mesh, v, fail);
  }
  for (std::int64_t i = 0; i < faces; ++i) {
    const std::int64_t corners = words.whole(first_of_next_line(words));
    if (corners < 3) words.fail(std::to_string(corners) + " corners", "3 or more");
    Fan fan;
    for (std::int64_t k = 0; k < corners; ++k) {
      const std::int64_t corner = words.whole(words.next_of_line());
      if (corner < 0 || corner >= vertices)
        words.fail("vertex " + std::to_string(corner), "0 to " + std::to_string(vertices - 1));
      fan.add(mesh, static_cast<std::uint32_t>(corner), fail);
    }
  }
  return mesh;
}

}  // namespace tandem
