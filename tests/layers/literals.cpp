// Every number below 1e-3 that a library's code knows stands in a tolerances.h, with its name and reason.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace fs = std::filesystem;

namespace {

constexpr std::array libraries{"narrowphase", "broadphase", "flowgraph", "engine"};
constexpr double least = 1e-3;

/// Where such numbers may stand: a file, or a folder that ends in /.
struct Exception {
  std::string_view path, reason;
};
constexpr std::array exceptions{
    Exception{"engine/scene/random.cpp", "a random generator's, no tolerances"},
    Exception{"flowgraph/step/clock.h", "nanoseconds to milliseconds"},
    Exception{"narrowphase/include/tandem/narrowphase/vertex_impact.h", "an option's default"},
};

struct Literal {
  int line;
  std::string text;
};

/// The numbers of a source outside comments and texts.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  std::vector<Literal> numbers() {
    std::vector<Literal> found;
    while (at_ < text_.size()) {
      if (starts("//")) {
        skip_to("\n");
      } else if (starts("/*")) {
        skip_to("*/");
      } else if (starts("R\"")) {
        const std::size_t open = text_.find('(', at_);
        skip_to(")" + std::string(text_.substr(at_ + 2, open - at_ - 2)) + "\"");
      } else if (text_[at_] == '"' || text_[at_] == '\'') {
        skip_quoted(text_[at_]);
      } else if (is_digit(at_) || (text_[at_] == '.' && is_digit(at_ + 1))) {
        found.push_back({line_, number()});
      } else if (is_word(at_)) {
        while (is_word(at_) && !starts("R\"")) ++at_;
      } else {
        step();
      }
    }
    return found;
  }

 private:
  bool starts(std::string_view s) const { return text_.substr(at_, s.size()) == s; }
  bool is_digit(std::size_t i) const {
    return i < text_.size() && std::isdigit(static_cast<unsigned char>(text_[i])) != 0;
  }
  bool is_word(std::size_t i) const {
    return i < text_.size() && (text_[i] == '_' || std::isalnum(static_cast<unsigned char>(text_[i])) != 0);
  }
  void step() {
    if (text_[at_] == '\n') ++line_;
    ++at_;
  }
  void skip_to(std::string_view end) {
    const std::size_t stop = text_.find(end, at_ + 1);
    const std::size_t behind = stop == text_.npos ? text_.size() : stop + end.size();
    while (at_ < behind) step();
  }
  void skip_quoted(char quote) {
    for (++at_; at_ < text_.size() && text_[at_] != quote; ++at_)
      if (text_[at_] == '\\') ++at_;
    ++at_;
  }
  /// A preprocessing number: signs belong to it behind an exponent's letter, p where it is hexadecimal.
  std::string number() {
    const char exponent = starts("0x") || starts("0X") ? 'p' : 'e';
    std::string out;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      const bool is_sign =
          (c == '+' || c == '-') && !out.empty() && std::tolower(static_cast<unsigned char>(out.back())) == exponent;
      if (!is_word(at_) && c != '.' && !is_sign && !(c == '\'' && is_word(at_ + 1))) break;
      if (c != '\'') out += c;
    }
    return out;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

std::vector<Literal> small_numbers(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  if (!in || !(text << in.rdbuf())) throw std::runtime_error(file.string() + ": cannot be read");
  std::vector<Literal> found = Scanner(text.view()).numbers();
  std::erase_if(found, [](const Literal& l) {
    const double value = std::strtod(l.text.c_str(), nullptr);
    return !(value > 0 && value < least);
  });
  return found;
}

std::vector<fs::path> sources(const fs::path& root) {
  std::vector<fs::path> files;
  for (const char* library : libraries) {
    if (!fs::exists(root / library)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / library))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
        files.push_back(entry.path().lexically_relative(root));
  }
  std::sort(files.begin(), files.end());
  return files;
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
      std::cerr << "literals ROOT: fails on a number below " << least << " outside of a tolerances.h\n";
      return 2;
    }
    int named = 0, faults = 0;
    std::set<std::string_view> needed;
    for (const fs::path& file : sources(argv[1])) {
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
