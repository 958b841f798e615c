// The exception for files that cannot be used.
#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

namespace tandem {

/// An input that cannot be used: what() is one line of less than 300 bytes that gives the place, the value found and
/// what is allowed.
class InputError : public std::invalid_argument {
 public:
  /// Message "WHERE: FOUND, allowed: ALLOWED", without the parts that are empty. The middle of a long `where` is left
  /// out. `found` is a short text.
  InputError(std::string_view where, std::string_view found, std::string_view allowed = {});
  /// The same error within a larger input: "OUTER: WHERE: ...".
  InputError within(std::string_view outer) const;

 private:
  std::string where_, found_, allowed_;
};

}  // namespace tandem
