// Parses JSON with limits, and errors that name the place as a JSON pointer.
#include "formats/json_reader.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>
#include <streambuf>
#include <vector>

namespace tandem {
namespace {

std::string escaped(std::string_view key) {
  std::string out;
  for (const char c : key) {
    if (c == '~')
      out += "~0";
    else if (c == '/')
      out += "~1";
    else
      out += c;
  }
  return out;
}

// Builds the document. Keys are compared when an object ends, since looking each one up would take quadratic time.
class Builder : public nlohmann::json_sax<Json> {
 public:
  explicit Builder(std::size_t& values_left) : values_left_(values_left) {}
  Json take() { return std::move(root_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool v) override { return add(v); }
  bool number_integer(number_integer_t v) override { return add(v); }
  bool number_unsigned(number_unsigned_t v) override { return add(v); }
  bool number_float(number_float_t v, const string_t&) override { return add(v); }
  bool string(string_t& v) override { return add(std::move(v)); }
  bool binary(binary_t& v) override { return add(std::move(v)); }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool key(string_t& v) override {
    key_.back() = std::move(v);
    return true;
  }
  bool end_object() override {
    std::vector<std::string_view> keys;
    for (const auto& [name, value] : open_.back()->get_ref<const Json::object_t&>()) keys.push_back(name);
    std::sort(keys.begin(), keys.end());
    const auto twice = std::adjacent_find(keys.begin(), keys.end());
    if (twice != keys.end()) {
      key_.back() = *twice;
      throw InputError(path(), "the key occurs twice", "once");
    }
    return close();
  }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t position, const std::string& token, const nlohmann::detail::exception& error) override {
    constexpr int out_of_range = 406;
    if (error.id == out_of_range) throw InputError(path(), quotation(token), "a number that fits a double");
    std::string what = error.what();
    // nlohmann's text is "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error ...": keep the
    // reason.
    const std::size_t reason = what.find("syntax error");
    if (reason != std::string::npos) what.erase(0, reason);
    const std::string where = open_.empty() ? std::string() : path() + ": ";
    throw InputError(where + "byte " + std::to_string(position),
                     shortened(on_one_line(what), 2 * limits::quoted_bytes));
  }

 private:
  template <typename T>
  bool add(T&& value) {
    place(Json(std::forward<T>(value)));
    return true;
  }
  Json* place(Json value) {
    if (values_left_ == 0)
      throw InputError(path(), "a document of more values", "at most " + std::to_string(limits::json_values));
    --values_left_;
    if (open_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    if (open_.back()->is_array()) {
      auto& array = open_.back()->get_ref<Json::array_t&>();
      array.push_back(std::move(value));
      return &array.back();
    }
    // ordered_map is a vector whose own insertion searches for the key first.
    std::vector<Json::object_t::value_type, Json::object_t::allocator_type>& members =
        open_.back()->get_ref<Json::object_t&>();
    members.emplace_back(key_.back(), std::move(value));
    return &members.back().second;
  }
  bool open(Json value) {
    if (open_.size() == limits::json_depth)
      throw InputError(path(), value.is_array() ? "an array" : "an object",
                       "at most " + std::to_string(limits::json_depth) + " arrays and objects within each other");
    Json* placed = place(std::move(value));
    open_.push_back(placed);
    key_.emplace_back();
    return true;
  }
  bool close() {
    open_.pop_back();
    key_.pop_back();
    return true;
  }
  std::string path() const {
    std::string out;
    for (std::size_t i = 0; i < open_.size(); ++i)
      out += '/' + (open_[i]->is_array() ? std::to_string(open_[i]->size() - (i + 1 < open_.size() ? 1 : 0))
                                         : escaped(key_[i]));
    return out;
  }

  std::size_t& values_left_;
  Json root_;
  std::vector<Json*> open_;       // containers that have not ended, outermost first
  std::vector<std::string> key_;  // the last key read of each open object
};

/// Thrown to stop writing when enough characters are there.
struct Full {};

/// A stream buffer that keeps the first characters written to it.
class Beginning : public std::streambuf {
 public:
  explicit Beginning(std::size_t most) : most_(most) {}
  const std::string& text() const { return text_; }

 protected:
  int_type overflow(int_type c) override {
    text_ += traits_type::to_char_type(c);
    if (text_.size() > most_) throw Full();
    return c;
  }

 private:
  std::size_t most_;
  std::string text_;
};

/// A value as an error message quotes it; the value may be as large as the document.
std::string quotation_of(const Json& value) {
  constexpr std::string_view gap = "...";
  Beginning beginning(limits::quoted_bytes);
  std::ostream out(&beginning);
  out.exceptions(std::ios::badbit);
  try {
    out << value;
    return beginning.text();
  } catch (const Full&) {
    return std::string(first_characters(beginning.text(), limits::quoted_bytes - gap.size())).append(gap);
  }
}

std::string shown(double bound) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", bound);
  return text;
}

}  // namespace

Json parse_json(std::string_view text, Json* before_error, std::size_t* values_left) {
  std::size_t all = limits::json_values;
  Builder builder(values_left != nullptr ? *values_left : all);
  try {
    Json::sax_parse(text.begin(), text.end(), &builder);
  } catch (const InputError&) {
    if (before_error != nullptr) *before_error = builder.take();
    throw;
  }
  return builder.take();
}

std::size_t JsonRef::size() const { return value_->size(); }

std::string JsonRef::pointer() const {
  if (parent_ == nullptr) return {};
  return parent_->pointer() + '/' + (parent_->value_->is_array() ? std::to_string(index_) : escaped(key_));
}

void JsonRef::refuse(std::string_view allowed) const { refuse(quotation_of(*value_), allowed); }

void JsonRef::refuse(std::string_view found, std::string_view allowed) const {
  throw InputError(parent_ == nullptr ? "document" : pointer(), found, allowed);
}

JsonRef JsonRef::at(std::string_view key) const& {
  const std::optional<JsonRef> member = find(key);
  if (!member) throw InputError(pointer() + '/' + escaped(key), "missing", "a value");
  return *member;
}

std::optional<JsonRef> JsonRef::find(std::string_view key) const& {
  if (!value_->is_object()) refuse("an object");
  for (const auto& [name, value] : value_->get_ref<const Json::object_t&>())
    if (name == key) return JsonRef(value, this, name, 0);
  return std::nullopt;
}

void JsonRef::require_keys(std::initializer_list<std::string_view> allowed) const {
  if (!value_->is_object()) refuse("an object");
  for (const auto& [name, value] : value_->get_ref<const Json::object_t&>()) {
    if (std::find(allowed.begin(), allowed.end(), name) != allowed.end()) continue;
    std::string list;
    for (const std::string_view key : allowed) list += (list.empty() ? "" : ", ") + std::string(key);
    throw InputError(pointer() + '/' + escaped(name), "unknown key", list);
  }
}

JsonRef JsonRef::at(std::size_t index) const& { return {(*value_)[index], this, {}, index}; }

void JsonRef::require_array(std::string_view allowed) const {
  if (!value_->is_array()) refuse(allowed);
}

double JsonRef::number() const {
  if (!value_->is_number()) refuse("a number");
  return value_->get<double>();
}

double JsonRef::number_above(double bound) const {
  if (!value_->is_number() || !(value_->get<double>() > bound)) refuse("a number > " + shown(bound));
  return value_->get<double>();
}

double JsonRef::number_at_least(double bound) const {
  if (!value_->is_number() || !(value_->get<double>() >= bound)) refuse("a number >= " + shown(bound));
  return value_->get<double>();
}

double JsonRef::number_up_to(double most) const {
  const double value = number_at_least(0);
  if (value > most) refuse("a number, 0 to " + shown(most));
  return value;
}

Vec3 JsonRef::vec3_up_to(double most) const {
  const Vec3 value = vec3();
  if (value.cwiseAbs().maxCoeff() > most) refuse("three numbers of at most " + shown(most) + " in size");
  return value;
}

std::uint32_t JsonRef::whole(std::uint32_t most) const {
  if (!value_->is_number_unsigned() || value_->get<std::uint64_t>() > most)
    refuse("a whole number, 0 to " + std::to_string(most));
  return value_->get<std::uint32_t>();
}

bool JsonRef::flag() const {
  if (!value_->is_boolean()) refuse("true or false");
  return value_->get<bool>();
}

const std::string& JsonRef::text() const {
  if (!value_->is_string()) refuse("a string");
  return value_->get_ref<const std::string&>();
}

Vec3 JsonRef::vec3() const {
  if (!value_->is_array() || value_->size() != 3) refuse("three numbers [x, y, z]");
  return {at(0).number(), at(1).number(), at(2).number()};
}

}  // namespace tandem
