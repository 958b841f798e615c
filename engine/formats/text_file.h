#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "formats/input_error.h"
#include "formats/input_limits.h"

namespace tandem {

/// A file, pipe or device that is read in order, with bounds on what is taken. Errors of reading itself, which no other
/// request would mend, are std::runtime_error.
class InputFile {
 public:
  /// Opens. Throws InputError "PATH: reason" for a file that is missing, a directory or not to be read.
  explicit InputFile(const std::filesystem::path& path);
  /// A descriptor that is open and stays so, "stdin" as `name`.
  InputFile(int descriptor, std::string name);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& name() const { return name_; }
  /// Of a regular file that tells it; those of /proc do not, nor do pipes and devices.
  std::optional<std::uint64_t> size() const { return size_; }
  /// Bytes given so far.
  std::uint64_t position() const { return position_; }

  /// The first bytes of what is left, at most `most` (up to 65,536), without taking them.
  std::string_view peek(std::size_t most);
  /// Fills `to`; fewer bytes than `count` only at the end.
  std::size_t read(char* to, std::size_t count);
  /// All that is left. Throws InputError if it is more than `most` bytes, or than limits::stream_bytes where the file
  /// does not tell its size.
  std::string rest(std::uint64_t most);

  enum class Line { read, too_long, none };
  /// The next line, without its end; `none` at the end of the file. One of more than `most` bytes is taken to its end,
  /// but limits::skipped_bytes at most, behind which nothing more is read; `line` then holds its beginning.
  Line line(std::string& line, std::uint64_t most = limits::stream_bytes);

 private:
  void inspect();
  /// Bytes in the buffer, more of them if it was empty; none at the end.
  std::string_view buffered();
  void take(std::size_t count);
  [[noreturn]] void refuse_size(std::string_view found, std::uint64_t most) const;

  std::string name_;
  int descriptor_;
  bool owned_;
  std::optional<std::uint64_t> size_;
  std::string buffer_;
  std::size_t begin_ = 0, end_ = 0;  // of what is left in the buffer
  std::uint64_t position_ = 0;
  bool given_up_ = false;  // the end of a line was not found
};

/// "512 MiB".
std::string in_mebibytes(std::uint64_t bytes);

/// All of a file, as InputFile::rest.
std::string read_file(const std::filesystem::path& path, std::uint64_t most = limits::document_bytes);

}  // namespace tandem
