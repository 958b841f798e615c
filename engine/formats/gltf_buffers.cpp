// The buffers and accessors of glTF files.
#include "formats/gltf_buffers.h"

#include <limits>

#include "formats/text_file.h"

namespace tandem {
namespace {

constexpr std::uint32_t most = std::numeric_limits<std::uint32_t>::max();

std::uint32_t whole_or(const JsonRef& json, std::string_view key, std::uint32_t otherwise) {
  const auto value = json.find(key);
  return value ? value->whole(most) : otherwise;
}

/// Decodes base64 (RFC 4648); false where the text is not base64.
bool from_base64(std::string_view text, std::string& out) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::uint32_t bits = 0;
  unsigned held = 0;  // bits that do not make a whole byte yet
  for (const char c : text) {
    const std::size_t digit = digits.find(c);
    if (digit == std::string_view::npos) return false;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((held += 6) < 8) continue;
    held -= 8;
    out += static_cast<char>(bits >> held & 0xffu);
  }
  return true;
}

/// Decodes the percent signs of a URI, such as %20 for a space.
std::optional<std::string> without_percents(std::string_view uri) {
  const auto digit = [](char c) {
    constexpr std::string_view digits = "0123456789abcdef";
    return digits.find(static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c));
  };
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      out += uri[i];
      continue;
    }
    const std::size_t high = i + 2 < uri.size() ? digit(uri[i + 1]) : std::string_view::npos;
    const std::size_t low = i + 2 < uri.size() ? digit(uri[i + 2]) : std::string_view::npos;
    if (high == std::string_view::npos || low == std::string_view::npos) return std::nullopt;
    out += static_cast<char>(16 * high + low);
    i += 2;
  }
  return out;
}

std::size_t component_bytes(const JsonRef& component) {
  switch (component.whole(most)) {
    case 5121:
      return 1;
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      component.refuse("5126 (float); of indices 5121, 5123, 5125 (whole numbers of 1, 2, 4 bytes)");
  }
}

}  // namespace

GltfList::GltfList(const JsonRef& document, std::string_view name) : name_(name), array_(document.find(name)) {
  if (array_) array_->require_array("an array of objects");
}

JsonRef GltfList::at(std::size_t i) const& {
  const JsonRef object = array_->at(i);
  if (object.size() > limits::gltf_members)
    object.refuse(std::to_string(object.size()) + " members", "at most " + std::to_string(limits::gltf_members));
  return object;
}

std::uint32_t GltfList::place(const JsonRef& index) const {
  if (size() == 0) index.refuse("none: there is no /" + std::string(name_));
  return index.whole(static_cast<std::uint32_t>(size() - 1));
}

GltfBuffers::GltfBuffers(const JsonRef& document, std::string_view binary, const std::filesystem::path& folder)
    : accessors_(document, "accessors"),
      views_(document, "bufferViews"),
      buffers_(document, "buffers"),
      binary_(binary),
      folder_(folder),
      loaded_(buffers_.size()) {}

GltfNumbers GltfBuffers::numbers(const JsonRef& index, std::string_view type, std::size_t components) {
  const JsonRef accessor = accessors_.at(accessors_.place(index));
  if (accessor.find("sparse")) accessor.refuse("a sparse accessor", "none");
  const JsonRef type_json = accessor.at("type"), component = accessor.at("componentType");
  if (type_json.text() != type) type_json.refuse(type);
  GltfNumbers out;
  out.component = component.whole(most);
  const std::size_t element_bytes = components * component_bytes(component);
  out.count = accessor.at("count").whole(most);
  out.bytes = view(accessor.at("bufferView"), element_bytes, out.stride);
  const std::size_t offset = whole_or(accessor, "byteOffset", 0);
  const std::size_t needed = out.count == 0 ? 0 : out.stride * (out.count - std::size_t{1}) + element_bytes;
  if (offset > out.bytes.size() || needed > out.bytes.size() - offset)
    accessor.refuse(std::to_string(needed) + " bytes from byte " + std::to_string(offset),
                    "what is in its view of " + std::to_string(out.bytes.size()));
  out.bytes.remove_prefix(offset);
  return out;
}

std::string_view GltfBuffers::view(const JsonRef& index, std::size_t element_bytes, std::size_t& stride) {
  const JsonRef view = views_.at(views_.place(index));
  stride = element_bytes;
  if (const auto given = view.find("byteStride")) stride = given->whole(most);
  if (stride < element_bytes)
    view.refuse("byteStride " + std::to_string(stride), std::to_string(element_bytes) + " or more");
  const std::string_view all = buffer(view.at("buffer"));
  const std::size_t offset = whole_or(view, "byteOffset", 0), bytes = view.at("byteLength").whole(most);
  if (offset > all.size() || bytes > all.size() - offset)
    view.refuse(std::to_string(bytes) + " bytes from byte " + std::to_string(offset),
                "what is in its buffer of " + std::to_string(all.size()));
  return all.substr(offset, bytes);
}

std::string_view GltfBuffers::buffer(const JsonRef& index) {
  const std::uint32_t place = buffers_.place(index);
  const JsonRef buffer = buffers_.at(place);
  const std::uint32_t bytes = buffer.at("byteLength").whole(most);
  const auto uri = buffer.find("uri");
  if (!uri && place == 0 && binary_.size() >= bytes) return binary_.substr(0, bytes);
  if (!uri) buffer.refuse(std::to_string(bytes) + " bytes without uri", "the first, in a .glb that has as many");
  if (!loaded_[place]) {
    if ((bytes_loaded_ += bytes) > limits::mesh_bytes)
      buffer.refuse("one more buffer", "at most " + in_mebibytes(limits::mesh_bytes) + " in all");
    loaded_[place] = loaded(*uri, bytes);
  }
  return *loaded_[place];
}

std::string GltfBuffers::loaded(const JsonRef& uri, std::uint32_t bytes) const {
  const std::string& text = uri.text();
  std::string out;
  if (text.starts_with("data:")) {
    constexpr std::string_view mark = ";base64,";
    const std::size_t begin = text.find(mark);
    if (begin == std::string::npos || !from_base64(std::string_view(text).substr(begin + mark.size()), out))
      uri.refuse("a file's name, or data:...;base64,...");
    if (out.size() < bytes) uri.refuse(std::to_string(out.size()) + " bytes", std::to_string(bytes) + " and more");
    out.resize(bytes);
    return out;
  }
  const std::optional<std::string> name = without_percents(text);
  if (!name || name->find(':') != std::string::npos || std::filesystem::path(*name).is_absolute())
    uri.refuse("the name of a file relative to this one, or data:...;base64,...");
  try {
    InputFile file(folder_ / *name, InputFile::Kind::regular);
    if (file.size().value_or(0) < bytes)
      throw InputError(file.name(), std::to_string(file.size().value_or(0)) + " bytes",
                       "a file of " + std::to_string(bytes) + " and more");
    out.resize(bytes);
    out.resize(file.read(out.data(), bytes));
    if (out.size() < bytes) throw InputError(file.name(), "a file that shrinks", "one that stays");
  } catch (const InputError& error) {
    throw error.within(uri.pointer());
  }
  return out;
}

}  // namespace tandem
