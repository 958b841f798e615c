// Reads the triangles of an OBJ file.
#include <charconv>
#include <limits>
#include <string>
#include <vector>

#include "formats/growing_mesh.h"
#include "formats/mesh_readers.h"
#include "formats/words.h"

namespace tandem {
namespace {

/// The vertex indices of an OBJ file's faces. They may refer to vertices that come later, so they are checked at the
/// end.
class ObjFaces {
 public:
  explicit ObjFaces(const Words& words) : words_(words) {}

  /// A corner v, v/vt, v//vn or v/vt/vn, of which only v is used. `vertices`: the number of vertices read so far.
  std::uint32_t corner(std::string_view word, std::size_t vertices) {
    const std::string_view index = word.substr(0, word.find('/'));
    std::int64_t i = 0;
    const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), i);
    constexpr std::int64_t most = std::numeric_limits<std::uint32_t>::max();
    if (error != std::errc() || end != index.data() + index.size() || i == 0 || i > most)
      words_.fail(word, "the number of a vertex, from 1, or from -1 backwards");
    const auto known = static_cast<std::int64_t>(vertices);
    if (i < -known)
      throw InputError(words_.place(), "vertex " + std::to_string(i), "at most " + std::to_string(known) + " back");
    const auto out = static_cast<std::uint32_t>(i > 0 ? i - 1 : known + i);
    if (out >= known) later_.push_back({out, words_.line()});
    return out;
  }
  void require_below(std::size_t vertices, const std::string& file) const {
    for (const auto& [index, line] : later_)
      if (index >= vertices)
        throw InputError(file + ':' + std::to_string(line), "vertex " + std::to_string(std::uint64_t{index} + 1),
                         vertices == 0 ? "none: there are no vertices" : "1 to " + std::to_string(vertices));
  }

 private:
  struct Later {
    std::uint32_t index;  // from 0
    std::size_t line;
  };
  const Words& words_;
  std::vector<Later> later_;
};

}  // namespace

Mesh read_obj(const std::string& file, std::string_view text) {
  Mesh mesh;
  Words words(file, without_byte_order_mark(text));
  ObjFaces faces(words);
  const auto fail = [&](std::string_view found, std::string_view allowed) { words.fail(found, allowed); };
  do {
    const std::string_view keyword = words.next_of_line();
    if (keyword == "v") {
      Vec3 v;
      for (double& x : v) {
        const std::string_view word = words.next_of_line();
        if (word.empty()) words.fail({}, "three numbers after v");
        x = words.coordinate(word);
      }
      add_vertex(mesh, v, fail);
    } else if (keyword == "f") {
      Fan fan;
      for (std::string_view word = words.next_of_line(); !word.empty() && word[0] != '#'; word = words.next_of_line())
        fan.add(mesh, faces.corner(word, mesh.vertices.size()), fail);
      if (fan.corners() < 3) words.fail(std::to_string(fan.corners()) + " corners", "3 or more corners after f");
    }
  } while (words.next_line());
  if (mesh.triangles.empty()) throw InputError(file, "no faces", "one or more lines 'f ...'");
  faces.require_below(mesh.vertices.size(), file);
  return mesh;
}

}  // namespace tandem
