// Reads the values of command line options.
#include "option_text.h"

#include <charconv>
#include <cstdio>

#include "formats/input_error.h"

namespace tandem {
namespace {

std::string shown(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

}  // namespace

void refuse_option(std::string_view option, std::string_view found, std::string_view allowed) {
  throw RequestError(std::string(option) + ": '" + quotation(found) + "', allowed: " + std::string(allowed));
}

std::uint64_t whole_option(std::string_view option, std::string_view text, std::uint64_t least, std::uint64_t most) {
  std::uint64_t x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || end != text.data() + text.size() || x < least || x > most)
    refuse_option(option, text, "a whole number, " + std::to_string(least) + " to " + std::to_string(most));
  return x;
}

double number_option(std::string_view option, std::string_view text, double least, double most) {
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || end != text.data() + text.size() || !(x >= least && x <= most))
    refuse_option(option, text, "a number, " + shown(least) + " to " + shown(most));
  return x;
}

}  // namespace tandem
