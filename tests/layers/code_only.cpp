// Removes comments and texts from C++ sources.
#include "code_only.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace fs = std::filesystem;

namespace {

class Blanker {
 public:
  explicit Blanker(std::string_view text) : text_(text), out_(text) {}

  std::string blanked() {
    while (at_ < text_.size()) {
      if (starts("//")) {
        blank_to("\n");
      } else if (starts("/*")) {
        blank_to("*/");
      } else if (starts("R\"")) {
        const std::size_t open = text_.find('(', at_);
        blank_to(")" + std::string(text_.substr(at_ + 2, open - at_ - 2)) + "\"");
      } else if (text_[at_] == '"' || text_[at_] == '\'') {
        blank_quoted(text_[at_]);
      } else if (is_word(at_)) {
        // A quote inside a number separates digits; one before a word belongs to a raw text only if it is R alone.
        do ++at_;
        while (is_word(at_) || (at_ < text_.size() && text_[at_] == '\'' && is_number_ && is_word(at_ + 1)));
      } else {
        ++at_;
      }
      is_number_ = at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_])) != 0;
    }
    return out_;
  }

 private:
  bool starts(std::string_view s) const { return text_.substr(at_, s.size()) == s; }
  bool is_word(std::size_t i) const {
    return i < text_.size() && (text_[i] == '_' || std::isalnum(static_cast<unsigned char>(text_[i])) != 0);
  }
  void blank_to(std::string_view end) {
    const std::size_t stop = text_.find(end, at_ + 1);
    blank(stop == text_.npos ? text_.size() : stop + end.size());
  }
  void blank_quoted(char quote) {
    std::size_t i = at_ + 1;
    while (i < text_.size() && text_[i] != quote) i += text_[i] == '\\' ? 2 : 1;
    blank(std::min(i + 1, text_.size()));
  }
  void blank(std::size_t behind) {
    for (; at_ < behind; ++at_)
      if (text_[at_] != '\n') out_[at_] = ' ';
  }

  std::string_view text_;
  std::string out_;
  std::size_t at_ = 0;
  bool is_number_ = false;
};

}  // namespace

std::string code_only(std::string_view text) { return Blanker(text).blanked(); }

std::vector<fs::path> sources(const fs::path& root, const std::vector<std::string>& folders) {
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
        files.push_back(entry.path().lexically_relative(root));
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  if (!in || !(text << in.rdbuf())) throw std::runtime_error(file.string() + ": cannot be read");
  return text.str();
}
