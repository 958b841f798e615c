// Writes JSON text.
#include "formats/json_writer.h"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace tandem {

void JsonWriter::separate() {
  if (comma_) out_ += ',';
  out_ += space_;
  space_.clear();
}

JsonWriter& JsonWriter::open(char bracket) {
  separate();
  out_ += bracket;
  comma_ = false;
  return *this;
}

JsonWriter& JsonWriter::close(char bracket) {
  out_ += space_;
  space_.clear();
  out_ += bracket;
  comma_ = true;
  return *this;
}

JsonWriter& JsonWriter::key(std::string_view name) {
  value(name);
  out_ += ':';
  comma_ = false;
  return *this;
}

JsonWriter& JsonWriter::value(double number) {
  if (!std::isfinite(number)) throw std::runtime_error("a number in the answer is not finite");
  if (number == 0 && std::signbit(number)) return raw("-0.0");  // "-0" would be read as the integer 0
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, number).ptr;
  return raw({text, static_cast<std::size_t>(end - text)});
}

JsonWriter& JsonWriter::value(std::string_view text) {
  using Text = nlohmann::json;
  // A file name need not be UTF-8, but JSON must be.
  return raw(Text(text).dump(-1, ' ', false, Text::error_handler_t::replace));
}

JsonWriter& JsonWriter::value(const Vec3& v) {
  return begin_array().value(v.x()).value(v.y()).value(v.z()).end_array();
}

JsonWriter& JsonWriter::raw(std::string_view json) {
  separate();
  out_ += json;
  comma_ = true;
  return *this;
}

JsonWriter& JsonWriter::new_line(std::string_view indent) {
  space_ = '\n';
  space_ += indent;
  return *this;
}

}  // namespace tandem
