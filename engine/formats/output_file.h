// Output files that appear only when they are complete, and checked writing to descriptors.
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

/// Output that failed; the message is one line, "WHAT: reason".
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The reader of a pipe has closed it: no more output is wanted, which is not reported as a failure.
class ReaderGone : public OutputError {
 public:
  using OutputError::OutputError;
};

/// A buffer before a file descriptor; every write is checked.
class DescriptorBuffer : public std::streambuf {
 public:
  /// `what` begins the error messages. The caller keeps the descriptor.
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

/// A file that appears under its name only when it is complete: it is written beside it under a temporary name, renamed
/// by `commit`, and removed without. A device or pipe is written to directly.
class OutputFile {
 public:
  /// Opens the file. `option` ("--json") begins the messages. Throws std::invalid_argument for a directory, or a folder
  /// that does not exist or cannot be written, so that this is known before the work starts.
  OutputFile(std::string_view option, const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void append(std::string_view bytes) { buffer_.append(bytes); }
  void write(const void* bytes, std::size_t count) { append({static_cast<const char*>(bytes), count}); }
  std::ostream& stream() { return stream_; }
  /// Writes all remaining bytes and checks for errors; nothing can be appended afterwards. Throws OutputError.
  void finish();
  /// Finishes, if that has not been done, and renames the file to its name. Throws OutputError.
  void commit();

 private:
  std::string what_;
  std::filesystem::path target_;     // symbolic links resolved
  std::filesystem::path temporary_;  // empty: written directly
  int descriptor_;
  DescriptorBuffer buffer_;
  std::ostream stream_;
};

/// Throws std::invalid_argument if two of the files (options and paths; empty paths are ignored) are the same.
void require_different(const std::vector<std::pair<std::string_view, std::filesystem::path>>& files);

}  // namespace tandem
