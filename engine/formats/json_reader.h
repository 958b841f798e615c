// JSON values that know their place in the document, for error messages.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "formats/input_error.h"
#include "formats/input_limits.h"
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A JSON value; objects keep the order of the text.
using Json = nlohmann::ordered_json;

/// Parses one JSON value. Throws InputError for text that is not JSON, a number too large for a double, a key that
/// occurs twice in an object, or a document beyond limits::json_depth and json_values; `before_error` (if given) then
/// receives what was read so far. `values_left` (if given) replaces json_values, and is reduced by the number of values
/// read: for inputs of many lines.
Json parse_json(std::string_view text, Json* before_error = nullptr, std::size_t* values_left = nullptr);

/// A value together with its place in the document, so that every error can name it as a JSON pointer. Refers to its
/// parent, which must outlive it.
class JsonRef {
 public:
  explicit JsonRef(const Json& root) : value_(&root) {}

  const Json& value() const { return *value_; }
  std::string pointer() const;
  /// Throws InputError "POINTER: VALUE, allowed: ALLOWED", with the value shortened.
  [[noreturn]] void refuse(std::string_view allowed) const;
  /// The same with a description of what is wrong.
  [[noreturn]] void refuse(std::string_view found, std::string_view allowed) const;

  /// For objects: the member of that name, which must exist.
  JsonRef at(std::string_view key) const&;
  JsonRef at(std::string_view key) && = delete;
  /// For objects: the member of that name, if it exists.
  std::optional<JsonRef> find(std::string_view key) const&;
  std::optional<JsonRef> find(std::string_view key) && = delete;
  /// For objects: a member that the caller found in value().
  JsonRef member(std::string_view key, const Json& value) const& { return {value, this, key, 0}; }
  JsonRef member(std::string_view key, const Json& value) && = delete;
  /// Throws unless the value is an object whose keys are all among these.
  void require_keys(std::initializer_list<std::string_view> allowed) const;
  /// The number of members of an object, or elements of an array.
  std::size_t size() const;

  /// For arrays: element `index` < size().
  JsonRef at(std::size_t index) const&;
  JsonRef at(std::size_t index) && = delete;
  void require_array(std::string_view allowed) const;

  double number() const;
  double number_above(double bound) const;     ///< a number > bound
  double number_at_least(double bound) const;  ///< a number >= bound
  double number_up_to(double most) const;      ///< a number in [0, most]
  Vec3 vec3_up_to(double most) const;          ///< each component in [-most, most]
  std::uint32_t whole(std::uint32_t most) const;
  bool flag() const;
  const std::string& text() const;
  Vec3 vec3() const;

 private:
  JsonRef(const Json& value, const JsonRef* parent, std::string_view key, std::size_t index)
      : value_(&value), parent_(parent), key_(key), index_(index) {}

  const Json* value_;
  const JsonRef* parent_ = nullptr;
  std::string_view key_;   // of an object's member
  std::size_t index_ = 0;  // of an array's element
};

}  // namespace tandem
