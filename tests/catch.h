// Catch2 of version 2 or 3, whichever the system has, with the names of version 2: version 3 has no header of
// everything, and its string matchers are in another namespace, one of them with another name.
#pragma once
#if __has_include(<catch2/catch_test_macros.hpp>)
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <string>

using Catch::Approx;

namespace Catch {
namespace Matchers {
inline auto Contains(const std::string& part) { return ContainsSubstring(part); }
}  // namespace Matchers
using Matchers::Contains;
using Matchers::EndsWith;
using Matchers::StartsWith;
}  // namespace Catch
#else
#include <catch2/catch.hpp>
#endif

#include <iostream>

/// Skips a test for lack of something, which ctest shows as skipped.
#define TANDEM_SKIP(reason)                            \
  do {                                                 \
    std::cout << "skipped: " << reason << std::endl; \
    return;                                            \
  } while (false)
