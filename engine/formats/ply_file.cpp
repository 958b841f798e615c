// Reads the triangles of a PLY file.
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/binary_numbers.h"
#include "formats/growing_mesh.h"
#include "formats/mesh_readers.h"
#include "formats/words.h"

// Greg Turk, The PLY polygon file format, 1994: a text header names elements with their properties, then the elements'
// values follow as text or binary.

namespace tandem {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr struct {
  std::string_view name, other_name;
  Type type;
} types[] = {{"char", "int8", Type::int8},        {"uchar", "uint8", Type::uint8},     {"short", "int16", Type::int16},
             {"ushort", "uint16", Type::uint16},  {"int", "int32", Type::int32},       {"uint", "uint32", Type::uint32},
             {"float", "float32", Type::float32}, {"double", "float64", Type::float64}};

bool is_whole(Type type) { return type != Type::float32 && type != Type::float64; }

enum class Role { x, y, z, corners, other };

struct Property {
  Type type;
  std::optional<Type> count;  // of a list
  Role role = Role::other;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  bool has(Role role) const {
    return std::any_of(properties.begin(), properties.end(), [&](const Property& p) { return p.role == role; });
  }
};

struct Header {
  std::string_view format;
  std::vector<Element> elements;

  const Element* find(std::string_view name) const {
    const auto at = std::find_if(elements.begin(), elements.end(), [&](const Element& e) { return e.name == name; });
    return at == elements.end() ? nullptr : &*at;
  }
};

Type read_type(const Words& words, std::string_view word) {
  for (const auto& known : types)
    if (word == known.name || word == known.other_name) return known.type;
  words.fail(word, "char, uchar, short, ushort, int, uint, float, double, or int8 to float64");
}

Role role_of(const Element& element, const Property& property, std::string_view name) {
  if (element.name == "face" && property.count && (name == "vertex_indices" || name == "vertex_index"))
    return Role::corners;
  if (element.name != "vertex" || property.count) return Role::other;
  return name == "x" ? Role::x : name == "y" ? Role::y : name == "z" ? Role::z : Role::other;
}

Property read_property(Words& words, const Element& element) {
  Property property;
  std::string_view word = words.next_of_line();
  if (word == "list") {
    property.count = read_type(words, words.next_of_line());
    if (!is_whole(*property.count)) words.fail("a list counted by fractions", "a whole type");
    word = words.next_of_line();
  }
  property.type = read_type(words, word);
  const std::string_view name = words.next_of_line();
  property.role = role_of(element, property, name);
  if (property.role == Role::corners && !is_whole(property.type))
    words.fail("vertex numbers of that type", "a whole type");
  if (property.role != Role::other && element.has(property.role)) words.fail(name, "once an element");
  return property;
}

Element read_element(Words& words, std::set<std::string>& known) {
  Element element;
  element.name = words.next_of_line();
  if (!known.insert(element.name).second) words.fail(element.name, "each element once");
  const std::int64_t count = words.whole(words.next_of_line());
  if (count < 0) words.fail(std::to_string(count), "a number of elements");
  element.count = static_cast<std::uint64_t>(count);
  return element;
}

Header read_header(Words& words) {
  Header header;
  std::set<std::string> known;  // the elements' names
  if (const std::string_view first = words.next_of_line(); first != "ply") words.fail(first, "ply");
  while (words.next_line()) {
    const std::string_view keyword = words.next_of_line();
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
    if (keyword == "end_header") {
      words.next_line();
      return header;
    }
    if (keyword == "format") {
      header.format = words.next_of_line();
      if (header.format != "ascii" && header.format != "binary_little_endian" && header.format != "binary_big_endian")
        words.fail(header.format, "ascii, binary_little_endian, binary_big_endian");
    } else if (keyword == "element") {
      header.elements.push_back(read_element(words, known));
    } else if (keyword == "property") {
      if (header.elements.empty()) words.fail(keyword, "element before it");
      header.elements.back().properties.push_back(read_property(words, header.elements.back()));
    } else {
      words.fail(keyword, "format, comment, obj_info, element, property, end_header");
    }
  }
  words.fail({}, "end_header");
}

void check(const std::string& file, const Header& header) {
  if (header.format.empty()) throw InputError(file, "no format", "a line 'format ascii 1.0' or binary");
  const Element *vertex = header.find("vertex"), *face = header.find("face");
  if (vertex == nullptr || !vertex->has(Role::x) || !vertex->has(Role::y) || !vertex->has(Role::z))
    throw InputError(file, "no vertices", "an element vertex with x, y and z");
  if (face == nullptr || !face->has(Role::corners) || face->count == 0)
    throw InputError(file, "no faces", "an element face with a list vertex_indices");
}

class TextSource {
 public:
  explicit TextSource(Words& words) : words_(words) {}
  double coordinate(Type) { return words_.coordinate(); }
  std::int64_t whole(Type) { return words_.whole(); }
  void skip(Type) {
    if (words_.next().empty()) fail({}, "a number");
  }
  [[noreturn]] void fail(std::string_view found, std::string_view allowed) const { words_.fail(found, allowed); }

 private:
  Words& words_;
};

class BinarySource {
 public:
  BinarySource(const std::string& file, std::string_view bytes, std::size_t at, bool big_endian)
      : file_(file), bytes_(bytes), at_(at), big_endian_(big_endian) {}

  double coordinate(Type type) {
    const double x = type == Type::float64   ? next<double>()
                     : type == Type::float32 ? static_cast<double>(next<float>())
                                             : static_cast<double>(whole(type));
    if (!std::isfinite(x)) fail("a coordinate that is not finite", "finite numbers");
    return x;
  }
  std::int64_t whole(Type type) {
    switch (type) {
      case Type::int8:
        return next<std::int8_t>();
      case Type::uint8:
        return next<std::uint8_t>();
      case Type::int16:
        return next<std::int16_t>();
      case Type::uint16:
        return next<std::uint16_t>();
      case Type::int32:
        return next<std::int32_t>();
      default:
        return next<std::uint32_t>();
    }
  }
  void skip(Type type) {
    if (type == Type::float64)
      (void)next<std::uint64_t>();
    else
      (void)whole(type);  // a float has as many bytes as the integer it is read as
  }
  [[noreturn]] void fail(std::string_view found, std::string_view allowed) const {
    throw InputError(file_ + ": byte " + std::to_string(at_), found, allowed);
  }

 private:
  template <typename T>
  T next() {
    if (bytes_.size() - at_ < sizeof(T)) fail("end of file", "as many values as the header says");
    const T value = number_from<T>(bytes_.data() + at_, big_endian_);
    at_ += sizeof(T);
    return value;
  }

  const std::string& file_;
  std::string_view bytes_;
  std::size_t at_;
  bool big_endian_;
};

/// Reads the values of an element: one vertex or face.
template <typename Source, typename Fail>
void read_row(Mesh& mesh, const Element& element, std::uint64_t vertices, Source& source, const Fail& fail) {
  Vec3 v = Vec3::Zero();
  for (const Property& property : element.properties) {
    if (!property.count) {
      if (property.role == Role::other)
        source.skip(property.type);
      else
        v[static_cast<Eigen::Index>(property.role)] = source.coordinate(property.type);
      continue;
    }
    const std::int64_t count = source.whole(*property.count);
    if (count < 0) fail(std::to_string(count), "a number of values");
    Fan fan;
    for (std::int64_t k = 0; k < count; ++k) {
      if (property.role == Role::other) {
        source.skip(property.type);
        continue;
      }
      const std::int64_t corner = source.whole(property.type);
      if (corner < 0 || static_cast<std::uint64_t>(corner) >= vertices)
        fail("vertex " + std::to_string(corner), "0 up to below " + std::to_string(vertices));
      fan.add(mesh, static_cast<std::uint32_t>(corner), fail);
    }
    if (property.role == Role::corners && fan.corners() < 3)
      fail("a face of " + std::to_string(fan.corners()) + " corners", "3 or more");
  }
  if (element.name == "vertex") add_vertex(mesh, v, fail);
}

template <typename Source>
Mesh read_elements(const Header& header, Source&& source) {
  Mesh mesh;
  const auto fail = [&](std::string_view found, std::string_view allowed) { source.fail(found, allowed); };
  const std::uint64_t vertices = header.find("vertex")->count;
  for (const Element& element : header.elements)
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i)
      read_row(mesh, element, vertices, source, fail);
  return mesh;
}

}  // namespace

Mesh read_ply(const std::string& file, std::string_view bytes) {
  Words words(file, bytes);
  const Header header = read_header(words);
  check(file, header);
  if (header.format == "ascii") return read_elements(header, TextSource(words));
  return read_elements(header, BinarySource(file, bytes, words.position(), header.format == "binary_big_endian"));
}

}  // namespace tandem
