// Writes JSON text.
#pragma once
#include <concepts>
#include <string>
#include <string_view>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A writer of JSON text. Doubles have the shortest form that reads back as the same bits.
class JsonWriter {
 public:
  JsonWriter& begin_object() { return open('{'); }
  JsonWriter& end_object() { return close('}'); }
  JsonWriter& begin_array() { return open('['); }
  JsonWriter& end_array() { return close(']'); }
  JsonWriter& key(std::string_view name);

  /// Throws std::runtime_error for NaN and infinity, which JSON does not have.
  JsonWriter& value(double number);
  template <std::integral T>
  JsonWriter& value(T number) {
    return raw(std::to_string(number));
  }
  JsonWriter& value(bool flag) { return raw(flag ? "true" : "false"); }
  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view(text)); }
  JsonWriter& value(const Vec3& v);
  JsonWriter& null() { return raw("null"); }
  /// Appends text that is JSON already.
  JsonWriter& raw(std::string_view json);

  template <typename T>
  JsonWriter& member(std::string_view name, const T& v) {
    return key(name).value(v);
  }
  /// White space between two elements, for human readers.
  JsonWriter& new_line(std::string_view indent = {});

  const std::string& text() const { return out_; }
  void clear() {
    out_.clear();
    comma_ = false;
  }

 private:
  JsonWriter& open(char bracket);
  JsonWriter& close(char bracket);
  void separate();

  std::string out_;
  std::string space_;
  bool comma_ = false;  // the next element needs a comma before it
};

}  // namespace tandem
