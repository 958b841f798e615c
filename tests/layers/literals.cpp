// Checks that every number up to 1e-2 in the libraries' code is in a tolerances.h, with its name and reason.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "code_only.h"

namespace fs = std::filesystem;

namespace {

const std::vector<std::string> libraries{"narrowphase", "broadphase", "flowgraph", "engine"};
constexpr double most = 1e-2;

/// Places where such numbers are permitted: a file, or a folder that ends in /.
struct Exception {
  std::string_view path, reason;
};
constexpr std::array exceptions{
    Exception{"flowgraph/step/clock.h", "nanoseconds to milliseconds"},
    Exception{"flowgraph/step/step_form.cpp", "a share of time"},
    Exception{"narrowphase/include/tandem/narrowphase/hausdorff.h", "an option's default"},
    Exception{"narrowphase/include/tandem/narrowphase/vertex_impact.h", "an option's default"},
    Exception{"narrowphase/pairs/solver_table.cpp", "a table of measured errors"},
};

struct Literal {
  int line;
  std::string text;
};

bool is_digit(std::string_view s, std::size_t i) {
  return i < s.size() && std::isdigit(static_cast<unsigned char>(s[i])) != 0;
}
bool is_word(std::string_view s, std::size_t i) {
  return i < s.size() && (s[i] == '_' || std::isalnum(static_cast<unsigned char>(s[i])) != 0);
}

/// A preprocessing number: signs belong to it after an exponent's letter, which is p in hexadecimal. Moves past it.
std::string number_at(std::string_view code, std::size_t& at) {
  const bool hexadecimal = code.substr(at, 2) == "0x" || code.substr(at, 2) == "0X";
  const char exponent = hexadecimal ? 'p' : 'e';
  std::string out;
  for (; at < code.size(); ++at) {
    const char c = code[at];
    const bool is_sign =
        (c == '+' || c == '-') && !out.empty() && std::tolower(static_cast<unsigned char>(out.back())) == exponent;
    if (!is_word(code, at) && c != '.' && !is_sign && !(c == '\'' && is_word(code, at + 1))) break;
    if (c != '\'') out += c;
  }
  return out;
}

std::vector<Literal> numbers(std::string_view code) {
  std::vector<Literal> found;
  int line = 1;
  for (std::size_t at = 0; at < code.size();) {
    if (is_digit(code, at) || (code[at] == '.' && is_digit(code, at + 1))) {
      found.push_back({line, number_at(code, at)});
    } else if (is_word(code, at)) {
      while (is_word(code, at)) ++at;
    } else {
      if (code[at++] == '\n') ++line;
    }
  }
  return found;
}

std::vector<Literal> small_numbers(const fs::path& file) {
  std::vector<Literal> found = numbers(code_only(text_of(file)));
  std::erase_if(found, [](const Literal& l) {
    const double value = std::strtod(l.text.c_str(), nullptr);
    return !(value > 0 && value <= most);
  });
  return found;
}

const Exception* exception_for(const std::string& file) {
  const auto covers = [&](const Exception& e) {
    return e.path.ends_with('/') ? file.starts_with(e.path) : file == e.path;
  };
  const auto at = std::find_if(exceptions.begin(), exceptions.end(), covers);
  return at == exceptions.end() ? nullptr : &*at;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) {
      std::cerr << "literals ROOT: fails on a number from 0 to " << most << " outside of a tolerances.h\n";
      return 2;
    }
    int named = 0, faults = 0;
    std::set<std::string_view> needed;
    for (const fs::path& file : sources(argv[1], libraries)) {
      for (const Literal& l : small_numbers(fs::path(argv[1]) / file)) {
        if (file.filename() == "tolerances.h") {
          ++named;
        } else if (const Exception* e = exception_for(file.string())) {
          needed.insert(e->path);
        } else {
          ++faults;
          std::cout << file.string() << ":" << l.line << ": " << l.text << " has no name in a tolerances.h\n";
        }
      }
    }
    for (const Exception& e : exceptions)
      if (!needed.contains(e.path)) std::cout << "no exception is needed for " << e.path << " (" << e.reason << ")\n";
    std::cout << named << " numbers in tolerances.h, " << faults << " elsewhere\n";
    return faults == 0 && needed.size() == exceptions.size() ? 0 : 1;
  } catch (const std::exception& e) {
    std::cerr << "literals: " << e.what() << "\n";
    return 2;
  }
}
