#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

namespace tandem {

/// Input that cannot be used: what() is one line of less than 300 bytes that tells where, the value found and
/// what is allowed.
class InputError : public std::invalid_argument {
 public:
  /// "WHERE: FOUND, allowed: ALLOWED", without the parts that are empty. Of a long `where` the middle is left out.
  /// `found` is a short text.
  InputError(std::string_view where, std::string_view found, std::string_view allowed = {});
  /// Makes the same error, found in a larger whole: "OUTER: WHERE: ...".
  InputError within(std::string_view outer) const;

 private:
  std::string where_, found_, allowed_;
};

}  // namespace tandem
