// Checks that functions of the libraries and benches have at most 60 lines, and lines at most 120 columns.
#include <algorithm>
#include <cctype>
#include <exception>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "code_only.h"

namespace fs = std::filesystem;

namespace {

const std::vector<std::string> folders{"narrowphase", "broadphase", "flowgraph", "engine", "bench"};
constexpr int most_lines = 60;
constexpr std::size_t most_columns = 120;

struct Function {
  int line, lines;
  std::string name;
};

bool is_word(char c) { return c == '_' || std::isalnum(static_cast<unsigned char>(c)) != 0; }

bool has_word(std::string_view text, std::string_view word) {
  for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) {
    const std::size_t behind = at + word.size();
    if ((at == 0 || !is_word(text[at - 1])) && (behind == text.size() || !is_word(text[behind]))) return true;
  }
  return false;
}

/// The name before the first parenthesis of the text before a body.
std::string name_in(std::string_view head) {
  std::size_t end = head.find('(');
  while (end > 0 && std::isspace(static_cast<unsigned char>(head[end - 1])) != 0) --end;
  std::size_t begin = end;
  while (begin > 0 && (is_word(head[begin - 1]) || head[begin - 1] == ':' || head[begin - 1] == '~')) --begin;
  return std::string(head.substr(begin, end - begin));
}

/// Finds the functions of a source by their braces: a block outside of any other function, only within namespaces and
/// classes, preceded by parentheses, and not a list of values. Its lines are those from brace to brace.
class FunctionFinder {
 public:
  explicit FunctionFinder(std::string_view code) : code_(code) {}

  std::vector<Function> functions() {
    for (at_ = 0; at_ < code_.size(); ++at_) {
      const char c = code_[at_];
      if (c == '\n') ++line_;
      if (c == '#' && depth_in_function_ == 0) skip_directive();
      if (depth_in_function_ > 0) {
        if (c == '{') ++depth_in_function_;
        if (c == '}' && --depth_in_function_ == 0) close();
      } else if (c == '{') {
        open(code_.substr(head_, at_ - head_));
      } else if (c == ';' || c == '}') {
        head_ = at_ + 1;
      }
    }
    return found_;
  }

 private:
  void skip_directive() {
    for (; at_ < code_.size() && code_[at_] != '\n'; ++at_)
      if (code_[at_] == '\\' && at_ + 1 < code_.size() && code_[at_ + 1] == '\n') ++line_, ++at_;
    ++line_;
    head_ = at_ + 1;
  }
  void open(std::string_view head) {
    const bool has_parentheses = head.find('(') != head.npos;
    const bool is_scope = has_word(head, "namespace") || has_word(head, "enum") ||
                          (!has_parentheses && (has_word(head, "class") || has_word(head, "struct") ||
                                                has_word(head, "union") || has_word(head, "extern")));
    if (is_scope) {
      head_ = at_ + 1;
      return;
    }
    depth_in_function_ = 1;
    open_line_ = line_;
    is_function_ = has_parentheses;
    if (has_parentheses) name_ = name_in(head);
  }
  /// After a member initializer in braces the same function goes on: its head is kept.
  void close() {
    const bool goes_on = is_function_ && goes_on_behind();
    if (is_function_ && !goes_on) found_.push_back({open_line_, line_ - open_line_ + 1, name_});
    if (!goes_on) head_ = at_ + 1;
  }
  bool goes_on_behind() const {
    const std::size_t next = code_.find_first_not_of(" \n", at_ + 1);
    return next != code_.npos && (code_[next] == ',' || code_[next] == '{');
  }

  std::string_view code_;
  std::size_t at_ = 0, head_ = 0;
  int line_ = 1, open_line_ = 0, depth_in_function_ = 0;
  bool is_function_ = false;
  std::string name_;
  std::vector<Function> found_;
};

/// Characters of UTF-8, not bytes.
std::size_t columns(std::string_view line) {
  std::size_t n = 0;
  for (const char c : line) n += (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  return n;
}

int wide_lines(const fs::path& file, std::string_view text) {
  int faults = 0, number = 1;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::size_t n = columns(text.substr(at, end - at));
    if (n > most_columns) {
      ++faults;
      std::cout << file.string() << ":" << number << ": " << n << " columns\n";
    }
    at = end + 1;
  }
  return faults;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) {
      std::cerr << "functions ROOT: fails on a function of more than " << most_lines
                << " lines and on a line of more than " << most_columns << " columns\n";
      return 2;
    }
    int faults = 0;
    std::size_t functions = 0;
    for (const fs::path& file : sources(argv[1], folders)) {
      const std::string text = text_of(fs::path(argv[1]) / file), code = code_only(text);
      faults += wide_lines(file, text);
      const std::vector<Function> found = FunctionFinder(code).functions();
      functions += found.size();
      for (const Function& f : found)
        if (f.lines > most_lines) {
          ++faults;
          std::cout << file.string() << ":" << f.line << ": " << f.name << " has " << f.lines << " lines\n";
        }
    }
    std::cout << functions << " functions, " << faults << " faults\n";
    return faults == 0 ? 0 : 1;
  } catch (const std::exception& e) {
    std::cerr << "functions: " << e.what() << "\n";
    return 2;
  }
}
