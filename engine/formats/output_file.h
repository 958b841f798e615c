#pragma once
#include <cstddef>
#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// Output that failed: one line, "WHAT: reason".
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The reader of a pipe went away: no more output is wanted, which is no failure worth a word.
class ReaderGone : public OutputError {
 public:
  using OutputError::OutputError;
};

/// Buffered bytes to a file descriptor; every write is checked.
class DescriptorBuffer : public std::streambuf {
 public:
  /// `what` opens the messages; the descriptor stays the caller's.
  DescriptorBuffer(int descriptor, std::string what) : descriptor_(descriptor), what_(std::move(what)) {}
  /// Throws OutputError when the bytes cannot be written.
  void append(std::string_view bytes);
  void flush();

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;

 private:
  int descriptor_;
  std::string what_;
  std::string waiting_;
};

/// A file that appears under its name only when it is complete: written beside it under a temporary name, renamed by
/// `commit`, removed without. A device or pipe is written to directly.
class OutputFile {
 public:
  /// Opens. `option` ("--json") opens the messages. Throws std::invalid_argument for a directory, a folder that does
  /// not exist or cannot be written: what is known before the work starts.
  OutputFile(std::string_view option, const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void append(std::string_view bytes) { buffer_.append(bytes); }
  void write(const void* bytes, std::size_t count) { append({static_cast<const char*>(bytes), count}); }
  std::ostream& stream() { return stream_; }
  /// All bytes are on their way and none was refused; nothing can be appended any more. Throws OutputError.
  void finish();
  /// Finishes, if that is still to do, and gives the file its name. Throws OutputError.
  void commit();

 private:
  std::string what_;
  std::filesystem::path target_;     // symbolic links resolved
  std::filesystem::path temporary_;  // empty: written directly
  int descriptor_;
  DescriptorBuffer buffer_;
  std::ostream stream_;
};

/// Throws std::invalid_argument if two of the files (options and paths; empty paths are passed over) are one.
void require_different(const std::vector<std::pair<std::string_view, std::filesystem::path>>& files);

}  // namespace tandem
