// The buffers and accessors of glTF files (Khronos, glTF 2.0 specification, 3.6).
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/json_reader.h"

namespace tandem {

/// One of a glTF document's arrays of objects, which are referred to by index.
class GltfList {
 public:
  /// `document` must outlive it.
  GltfList(const JsonRef& document, std::string_view name);
  std::size_t size() const { return array_ ? array_->size() : 0; }
  /// Throws InputError for an object of more than limits::gltf_members members.
  JsonRef at(std::size_t i) const&;
  JsonRef at(std::size_t i) && = delete;
  /// The index that a value holds. Throws InputError if it is out of range.
  std::uint32_t place(const JsonRef& index) const;

 private:
  std::string_view name_;
  std::optional<JsonRef> array_;
};

/// The numbers of an accessor, element by element.
struct GltfNumbers {
  std::string_view bytes;  ///< from the first element on
  std::size_t stride = 0;  ///< bytes from one element to the next
  std::uint32_t count = 0;
  unsigned component = 0;  ///< component type: 5126 float; 5121, 5123, 5125 whole numbers of 1, 2, 4 bytes

  const char* element(std::uint32_t i) const { return bytes.data() + stride * i; }
};

/// The bytes of a glTF 2.0 document: in its GLB chunk, in files beside it, or in its text as base64.
class GltfBuffers {
 public:
  /// `binary`: the chunk of a GLB file. All arguments are kept by reference.
  GltfBuffers(const JsonRef& document, std::string_view binary, const std::filesystem::path& folder);

  /// The accessor that `index` names, whose elements have `components` numbers each. Throws InputError for an accessor
  /// of another `type`, one that is sparse or without bytes, or one that exceeds its buffer.
  GltfNumbers numbers(const JsonRef& index, std::string_view type, std::size_t components);

 private:
  std::string_view view(const JsonRef& index, std::size_t element_bytes, std::size_t& stride);
  std::string_view buffer(const JsonRef& index);
  std::string loaded(const JsonRef& uri, std::uint32_t bytes) const;

  GltfList accessors_, views_, buffers_;
  std::string_view binary_;
  const std::filesystem::path& folder_;
  std::vector<std::optional<std::string>> loaded_;  // one for each buffer, loaded on first use
  std::uint64_t bytes_loaded_ = 0;
};

}  // namespace tandem
