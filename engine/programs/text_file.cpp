#include "text_file.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace tandem {

std::string read_file(const std::filesystem::path& path) {
  const auto fail = [&]() -> InputError { return InputError(path.string() + ": " + std::strerror(errno)); };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw InputError(path.string() + ": a directory, allowed: a file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw fail();
  std::string text;
  std::array<char, 1 << 16> part;
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), file.get())) text.append(part.data(), n);
  if (std::ferror(file.get())) throw fail();
  return text;
}

}  // namespace tandem
