// Names of enumerators, and memory as a dict.
#pragma once
#include <pybind11/pybind11.h>

#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace tandem::python {

/// Memory in bytes by data structure, as a dict.
inline pybind11::dict by_part(std::initializer_list<std::pair<const char*, std::size_t>> parts) {
  pybind11::dict out;
  for (const auto& [name, bytes] : parts) out[name] = bytes;
  return out;
}

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
