// Input files, read in order and with limits.
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

/// A file, pipe or device that is read in order, with limits on its size. Read errors, which no other request would
/// avoid, are std::runtime_error.
class InputFile {
 public:
  /// What may be opened. A pipe that nobody writes to is waited for, unless only regular files are allowed: these are
  /// what a file names, since whoever reads a scene or a record need not know what it refers to.
  enum class Kind { any, regular };
  /// Opens a file. Throws InputError "PATH: reason" if it is missing, a directory, of another kind or not readable.
  explicit InputFile(const std::filesystem::path& path, Kind kind = Kind::any);
  /// Reads from an open descriptor, which stays open; `name`: such as "stdin".
  InputFile(int descriptor, std::string name);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& name() const { return name_; }
  /// The size of a regular file that reports it; files of /proc, pipes and devices do not.
  std::optional<std::uint64_t> size() const { return size_; }
  /// The number of bytes returned so far.
  std::uint64_t position() const { return position_; }

  /// The next bytes, at most `most` (up to 65,536), without consuming them.
  std::string_view peek(std::size_t most);
  /// Fills `to`; fewer bytes than `count` only at the end of the file.
  std::size_t read(char* to, std::size_t count);
  /// All remaining bytes. Throws InputError if they are more than `most`, or than limits::stream_bytes where the size
  /// is not known.
  std::string rest(std::uint64_t most);

  enum class Line { read, too_long, none };
  /// The next line, without its end; `none` at the end of the file. A line of more than `most` bytes is skipped to its
  /// end, but for at most limits::skipped_bytes, after which nothing more is read; `line` then holds its beginning.
  Line line(std::string& line, std::uint64_t most = limits::stream_bytes);

 private:
  void require_regular(unsigned mode) const;
  void inspect();
  /// The bytes in the buffer, filled if it was empty; none at the end.
  std::string_view buffered();
  void take(std::size_t count);
  [[noreturn]] void refuse_size(std::string_view found, std::uint64_t most) const;

  std::string name_;
  int descriptor_;
  bool owned_;
  std::optional<std::uint64_t> size_;
  std::string buffer_;
  std::size_t begin_ = 0, end_ = 0;  // the bytes not yet consumed
  std::uint64_t position_ = 0;
  bool given_up_ = false;  // the end of a line was not found
};

/// A size as text: "512 MiB".
std::string in_mebibytes(std::uint64_t bytes);

/// All of a file, as InputFile::rest.
std::string read_file(const std::filesystem::path& path, std::uint64_t most = limits::document_bytes);

}  // namespace tandem
