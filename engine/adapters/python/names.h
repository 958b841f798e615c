#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

namespace tandem::python {

/// The value of that name. Throws std::invalid_argument "WHAT: TEXT, allowed: ...".
template <class Kinds>
auto named(std::string_view text, std::string_view what, const Kinds& kinds) {
  std::string all;
  for (const auto kind : kinds) {
    if (name(kind) == text) return kind;
    all += (all.empty() ? "" : ", ") + std::string(name(kind));
  }
  throw std::invalid_argument(std::string(what) + ": '" + std::string(text) + "', allowed: " + all);
}

}  // namespace tandem::python
