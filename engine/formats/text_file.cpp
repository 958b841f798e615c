// Input files, read in order and with limits.
#include "formats/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace tandem {
namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 16;

}  // namespace

std::string in_mebibytes(std::uint64_t bytes) { return std::to_string(bytes / limits::mebibyte) + " MiB"; }

InputFile::InputFile(const std::filesystem::path& path, Kind kind)
    : name_(path.string()), descriptor_(-1), owned_(true) {
  // The system would ignore the rest of the name after a zero byte.
  if (name_.find('\0') != std::string::npos) throw InputError(name_, "a zero byte", "a name without one");
  // Asked before it is opened, which would wait for the writer of a pipe, or release one.
  struct ::stat known {};
  if (kind == Kind::regular && ::stat(path.c_str(), &known) == 0) require_regular(known.st_mode);
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw InputError(name_, std::strerror(errno), "a file that can be read");
  try {
    inspect();
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

InputFile::InputFile(int descriptor, std::string name)
    : name_(std::move(name)), descriptor_(descriptor), owned_(false) {
  inspect();
}

InputFile::~InputFile() {
  if (owned_) ::close(descriptor_);
}

void InputFile::require_regular(unsigned mode) const {
  if (S_ISDIR(mode)) throw InputError(name_, "a directory", "a file");
  if (!S_ISREG(mode)) throw InputError(name_, "a pipe or device", "a regular file");
}

void InputFile::inspect() {
  struct ::stat about {};
  if (::fstat(descriptor_, &about) != 0) throw InputError(name_, std::strerror(errno), "a file that can be read");
  if (S_ISDIR(about.st_mode)) throw InputError(name_, "a directory", "a file");
  // Files of /proc are regular with size 0.
  if (S_ISREG(about.st_mode) && about.st_size > 0) size_ = static_cast<std::uint64_t>(about.st_size);
  buffer_.resize(buffer_bytes);
}

std::string_view InputFile::buffered() {
  if (begin_ == end_) {
    begin_ = end_ = 0;
    (void)peek(1);
  }
  return std::string_view(buffer_).substr(begin_, end_ - begin_);
}

void InputFile::take(std::size_t count) {
  begin_ += count;
  position_ += count;
}

std::string_view InputFile::peek(std::size_t most) {
  if (begin_ + most > buffer_.size()) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
  }
  while (end_ - begin_ < most) {
    const ::ssize_t got = ::read(descriptor_, buffer_.data() + end_, buffer_.size() - end_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw std::runtime_error(name_ + ": " + std::strerror(errno));
    if (got == 0) break;
    end_ += static_cast<std::size_t>(got);
  }
  return std::string_view(buffer_).substr(begin_, std::min(most, end_ - begin_));
}

std::size_t InputFile::read(char* to, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    const std::string_view part = buffered().substr(0, count - done);
    if (part.empty()) break;
    std::copy(part.begin(), part.end(), to + done);
    done += part.size();
    take(part.size());
  }
  return done;
}

void InputFile::refuse_size(std::string_view found, std::uint64_t most) const {
  throw InputError(name_, found, "at most " + in_mebibytes(most));
}

std::string InputFile::rest(std::uint64_t most) {
  std::string out;
  if (size_) {
    const std::uint64_t left = *size_ - std::min(*size_, position_);
    if (left > most) refuse_size(in_mebibytes(left), most);
    out.reserve(left);
  } else {
    most = std::min(most, limits::stream_bytes);
  }
  for (std::string_view part = buffered(); !part.empty(); part = buffered()) {
    if (part.size() > most - out.size()) refuse_size("a pipe, device or growing file that goes on", most);
    out += part;
    take(part.size());
  }
  return out;
}

InputFile::Line InputFile::line(std::string& line, std::uint64_t most) {
  line.clear();
  std::uint64_t skipped = 0;
  for (std::string_view part = buffered(); !part.empty() && !given_up_; part = buffered()) {
    const std::size_t end = part.find('\n');
    const std::string_view of_line = part.substr(0, end);
    const std::size_t kept = std::min<std::uint64_t>(of_line.size(), most - line.size());
    line += of_line.substr(0, kept);
    skipped += of_line.size() - kept;
    take(std::min(of_line.size() + 1, part.size()));
    if (end != std::string_view::npos) return skipped == 0 ? Line::read : Line::too_long;
    given_up_ = skipped > limits::skipped_bytes;
  }
  if (skipped > 0) return Line::too_long;
  return line.empty() ? Line::none : Line::read;
}

std::string read_file(const std::filesystem::path& path, std::uint64_t most) { return InputFile(path).rest(most); }

}  // namespace tandem
