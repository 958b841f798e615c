#pragma once
#include <span>
#include <string_view>

namespace tandem::bench {

/// A file that was put into the program when it was built.
struct Asset {
  std::string_view name;  ///< as in the page's folder, or LIBRARY/FILE
  std::string_view bytes;
};

std::span<const Asset> assets();

/// Throws std::out_of_range for a name that is not among them.
std::string_view asset(std::string_view name);

/// Why the libraries that the page needs are not among the assets; empty if they are.
std::string_view missing_libraries();

}  // namespace tandem::bench
