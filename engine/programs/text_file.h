#pragma once
#include <filesystem>
#include <stdexcept>
#include <string>

namespace tandem {

/// Input that cannot be used: what() is one line that names where, the value found and what is allowed.
class InputError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The bytes of a file. Throws InputError "PATH: reason" when it is missing, a directory or cannot be read.
std::string read_file(const std::filesystem::path& path);

}  // namespace tandem
