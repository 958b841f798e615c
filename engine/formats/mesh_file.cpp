#include "tandem/formats/mesh_file.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "formats/text_file.h"

namespace tandem {
namespace {

/// Some editors write one before UTF-8.
std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (text.starts_with(mark)) text.remove_prefix(mark.size());
  return text;
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f'; }

// Words of a text with the line they stand in. With `by_line`, a word beyond the current line is not given until
// `next_line`.
class Words {
 public:
  Words(const std::string& file, std::string_view text) : file_(file), text_(text) {}

  std::size_t line() const { return line_; }
  std::string place() const { return file_ + ':' + std::to_string(line_); }
  [[noreturn]] void fail(std::string_view found, std::string_view allowed) const {
    throw InputError(place(), '\'' + quotation(found) + '\'', allowed);
  }

  /// The next word of the text; empty at its end.
  std::string_view next() {
    skip(true);
    return word();
  }
  /// The next word of this line; empty at its end. A backslash there joins the next line to this one.
  std::string_view next_of_line() {
    skip(false);
    while (at_ < text_.size() && text_[at_] == '\\' && joins()) skip(false);
    return word();
  }
  bool next_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    if (at_ == text_.size()) return false;
    ++at_;
    ++line_;
    return at_ < text_.size();
  }

 private:
  void skip(bool lines) {
    for (; at_ < text_.size() && is_space(text_[at_]); ++at_) {
      if (text_[at_] != '\n') continue;
      if (!lines) return;
      ++line_;
    }
  }
  bool joins() {
    std::size_t end = at_ + 1;
    if (end < text_.size() && text_[end] == '\r') ++end;
    if (end >= text_.size() || text_[end] != '\n') return false;
    at_ = end + 1;
    ++line_;
    return true;
  }
  std::string_view word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  const std::string& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

double coordinate(const Words& words, std::string_view word) {
  std::string_view digits = word;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double x = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), x);
  // Too small for a double is zero for every purpose here.
  const bool tiny =
      error == std::errc::result_out_of_range && std::abs(std::strtod(std::string(digits).c_str(), nullptr)) < 1;
  if (tiny) return 0;
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(x))
    words.fail(word, "a finite number");
  return x;
}

/// Vertex numbers of an OBJ file's faces. They may name vertices that come later, so that these are checked at the end.
class ObjFaces {
 public:
  explicit ObjFaces(const Words& words) : words_(words) {}

  /// v, v/vt, v//vn or v/vt/vn: only v is of use. `vertices` are known so far.
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
                         "1 to " + std::to_string(vertices));
  }

 private:
  struct Later {
    std::uint32_t index;  // from 0
    std::size_t line;
  };
  const Words& words_;
  std::vector<Later> later_;
};

void add_triangle(Mesh& mesh, const std::array<std::uint32_t, 3>& triangle, const Words& words) {
  if (mesh.triangles.size() == limits::mesh_triangles)
    words.fail("one more triangle", "at most " + std::to_string(limits::mesh_triangles) + " in all");
  mesh.triangles.push_back(triangle);
}

Mesh read_obj(const std::string& file, std::string_view text) {
  Mesh mesh;
  Words words(file, without_byte_order_mark(text));
  ObjFaces faces(words);
  do {
    const std::string_view keyword = words.next_of_line();
    if (keyword == "v") {
      Vec3 v;
      for (double& x : v) {
        const std::string_view word = words.next_of_line();
        if (word.empty()) words.fail("", "three numbers after v");
        x = coordinate(words, word);
      }
      mesh.vertices.push_back(v);
    } else if (keyword == "f") {
      std::array<std::uint32_t, 3> triangle{};
      std::size_t corners = 0;
      for (std::string_view word = words.next_of_line(); !word.empty() && word[0] != '#'; word = words.next_of_line()) {
        const std::uint32_t corner = faces.corner(word, mesh.vertices.size());
        if (corners > 2) triangle[1] = triangle[2];
        triangle[std::min<std::size_t>(corners, 2)] = corner;
        if (++corners > 2) add_triangle(mesh, triangle, words);
      }
      if (corners < 3) words.fail(std::to_string(corners) + " corners", "3 or more corners after f");
    }
  } while (words.next_line());
  if (mesh.triangles.empty()) throw InputError(file, "no faces", "one or more lines 'f ...'");
  faces.require_below(mesh.vertices.size(), file);
  return mesh;
}

// Makes corners with equal coordinates one vertex, numbered in the order of their first appearance.
class Welder {
 public:
  explicit Welder(Mesh& mesh) : mesh_(mesh) {}
  std::uint32_t add(const Vec3& v) {
    // -0 and 0 are the same place.
    const std::array<double, 3> key{v.x() + 0.0, v.y() + 0.0, v.z() + 0.0};
    const auto [found, is_new] = numbers_.emplace(key, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) mesh_.vertices.push_back(v);
    return found->second;
  }

 private:
  Mesh& mesh_;
  std::map<std::array<double, 3>, std::uint32_t> numbers_;
};

Mesh read_ascii_stl(const std::string& file, std::string_view text) {
  Mesh mesh;
  Welder welder(mesh);
  Words words(file, text);
  const auto expect = [&](std::string_view wanted) {
    const std::string_view word = words.next();
    if (word != wanted) words.fail(word.empty() ? "end of file" : word, wanted);
  };
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word != "solid") words.fail(word, "'solid'");
    words.next_line();  // the rest of this line is the solid's name
    for (word = words.next(); word == "facet"; word = words.next()) {
      expect("normal");
      for (int i = 0; i < 3; ++i) words.next();  // often wrong; the corners' order says it
      expect("outer");
      expect("loop");
      std::array<std::uint32_t, 3> triangle;
      for (std::uint32_t& corner : triangle) {
        expect("vertex");
        Vec3 v;
        for (double& x : v) x = coordinate(words, words.next());
        corner = welder.add(v);
      }
      expect("endloop");
      expect("endfacet");
      add_triangle(mesh, triangle, words);
    }
    if (word != "endsolid") words.fail(word.empty() ? "end of file" : word, "'facet' or 'endsolid'");
    words.next_line();
  }
  if (mesh.triangles.empty()) throw InputError(file, "no facets", "one or more");
  return mesh;
}

constexpr std::size_t stl_header = 80, stl_start = 84, stl_facet = 50;

std::uint32_t little_endian(const char* bytes) {
  std::uint32_t x = 0;
  for (int i = 3; i >= 0; --i) x = x << 8 | static_cast<unsigned char>(bytes[i]);
  return x;
}

Mesh read_binary_stl(const std::string& file, std::string_view data) {
  const auto fail = [&](std::size_t byte, std::string_view found, std::string_view allowed) {
    throw InputError(file + ": byte " + std::to_string(byte), found, allowed);
  };
  const std::uint32_t facets = little_endian(data.data() + stl_header);
  const std::size_t needed = stl_start + stl_facet * std::size_t{facets};
  if (facets == 0) fail(stl_header, "0 facets", "one or more");
  if (data.size() < needed)
    fail(data.size(), "end of file", std::to_string(needed) + " bytes for " + std::to_string(facets) + " facets");
  Mesh mesh;
  Welder welder(mesh);
  mesh.triangles.resize(facets);
  for (std::size_t i = 0; i < facets; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = stl_start + stl_facet * i + 12 + 12 * k;  // behind the facet's normal
      Vec3 v;
      for (std::size_t axis = 0; axis < 3; ++axis)
        v[static_cast<Eigen::Index>(axis)] = std::bit_cast<float>(little_endian(data.data() + at + 4 * axis));
      if (!v.allFinite()) fail(at, "a coordinate that is not finite", "finite numbers");
      mesh.triangles[i][k] = welder.add(v);
    }
  }
  return mesh;
}

Mesh read_stl(const std::string& file, std::string_view data) {
  // Binary files may begin with "solid" too; the length they announce tells.
  const bool long_enough = data.size() >= stl_start;
  const bool fits =
      long_enough && data.size() == stl_start + stl_facet * std::size_t{little_endian(data.data() + stl_header)};
  const std::string_view text = without_byte_order_mark(data);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const bool says_solid = first != std::string_view::npos && text.substr(first, 5) == "solid";
  if (!fits && says_solid) return read_ascii_stl(file, text);
  if (!long_enough)
    throw InputError(file + ": byte " + std::to_string(data.size()), "end of file",
                     "'solid' or a binary STL's 84 bytes and more");
  return read_binary_stl(file, data);
}

}  // namespace

Mesh read_mesh_file(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".obj" && extension != ".stl")
    throw InputError(file, "extension '" + quotation(extension) + '\'', ".obj, .stl");
  const std::string text = read_file(path, limits::mesh_bytes);
  return extension == ".obj" ? read_obj(file, text) : read_stl(file, text);
}

}  // namespace tandem
