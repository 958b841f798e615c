// Values of command line options, checked.
#pragma once
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace tandem {

/// A wrong request: one line that names the option, the value found and what is allowed. Exit status 2.
class RequestError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

[[noreturn]] void refuse_option(std::string_view option, std::string_view found, std::string_view allowed);

/// The text as an integer in [least, most]. Throws RequestError.
std::uint64_t whole_option(std::string_view option, std::string_view text, std::uint64_t least, std::uint64_t most);

/// The text as a finite number in [least, most]. Throws RequestError.
double number_option(std::string_view option, std::string_view text, double least, double most);

/// The value whose name(...) is the text.
template <typename Enum, std::size_t n>
Enum named_option(std::string_view option, std::string_view text, const Enum (&values)[n]) {
  std::string list;
  for (const Enum value : values) {
    if (name(value) == text) return value;
    list += (list.empty() ? "" : ", ") + std::string(name(value));
  }
  refuse_option(option, text, list);
}

}  // namespace tandem
