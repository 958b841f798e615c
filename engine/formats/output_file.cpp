// Output files that appear only when they are complete.
#include "formats/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "formats/input_error.h"
#include "formats/input_limits.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

// Half a message, so that the reason behind it is not cut off.
std::string shown(std::string_view option, const fs::path& path) {
  return shortened(std::string(option) + ' ' + on_one_line(path.string()), limits::message_bytes / 2);
}

// The absolute path of the file that a path names, whether or not it exists.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  const fs::path whole = fs::absolute(path, error);
  if (error) return path;
  const fs::path known = fs::weakly_canonical(whole, error);
  return error ? path : known;
}

// The system would ignore the rest of the name after a zero byte.
const fs::path& named(const fs::path& path, const std::string& what) {
  if (path.empty() || path.string().find('\0') != std::string::npos)
    throw std::invalid_argument(what + (path.empty() ? ": no name" : ": a zero byte") + ", allowed: a file's name");
  return path;
}

int open_for_writing(const fs::path& path, const std::string& what) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0)
    throw std::invalid_argument(what + ": " + std::strerror(errno) + ", allowed: a file that can be written");
  return descriptor;
}

// The temporary path; empty for devices and pipes, which cannot be replaced by a file of the same name.
fs::path temporary_for(const fs::path& target, const std::string& what) {
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) throw std::invalid_argument(what + ": a directory, allowed: a file");
  if (fs::exists(status) && !fs::is_regular_file(status)) return {};
  return target.string() + ".tmp." + std::to_string(::getpid());
}

}  // namespace

void DescriptorBuffer::append(std::string_view bytes) {
  constexpr std::size_t enough = 1 << 18;
  waiting_ += bytes;
  if (waiting_.size() >= enough) flush();
}

void DescriptorBuffer::flush() {
  std::string_view rest = waiting_;
  while (!rest.empty()) {
    const ::ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int error = errno;
      waiting_.clear();
      const std::string message = what_ + ": " + std::strerror(error);
      if (error == EPIPE) throw ReaderGone(message);
      throw OutputError(message);
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  waiting_.clear();
}

DescriptorBuffer::int_type DescriptorBuffer::overflow(int_type c) {
  if (c != traits_type::eof()) append(std::string(1, traits_type::to_char_type(c)));
  return traits_type::not_eof(c);
}

std::streamsize DescriptorBuffer::xsputn(const char* bytes, std::streamsize count) {
  append({bytes, static_cast<std::size_t>(count)});
  return count;
}

OutputFile::OutputFile(std::string_view option, const fs::path& path)
    : what_(shown(option, path)),
      target_(resolved(named(path, what_))),
      temporary_(temporary_for(target_, what_)),
      descriptor_(open_for_writing(temporary_.empty() ? target_ : temporary_, what_)),
      buffer_(descriptor_, what_),
      stream_(&buffer_) {
  stream_.exceptions(std::ios::badbit);  // exceptions of the buffer pass through, with their reason
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void OutputFile::finish() {
  buffer_.flush();
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) throw OutputError(what_ + ": " + std::strerror(errno));
}

void OutputFile::commit() {
  if (descriptor_ >= 0) finish();
  if (temporary_.empty()) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) throw OutputError(what_ + ": " + std::strerror(errno));
  temporary_.clear();
}

void require_different(const std::vector<std::pair<std::string_view, fs::path>>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto& [option, path] = files[i];
      const auto& [other_option, other_path] = files[j];
      if (path.empty() || other_path.empty() || resolved(path) != resolved(other_path)) continue;
      throw std::invalid_argument(shown(option, path) + ": the same file as " + std::string(other_option) +
                                  ", allowed: another one");
    }
  }
}

}  // namespace tandem
