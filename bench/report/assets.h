// Files of the report's page, compiled into the program.
#pragma once
#include <span>
#include <string_view>

namespace tandem::bench {

/// A file compiled into the program.
struct Asset {
  std::string_view name;  ///< its path in the page's folder, or LIBRARY/FILE
  std::string_view bytes;
};

std::span<const Asset> assets();

/// The asset of this name. Throws std::out_of_range for an unknown one.
std::string_view asset(std::string_view name);

/// The reason why libraries of the page are missing among the assets; empty if none is.
std::string_view missing_libraries();

}  // namespace tandem::bench
