#pragma once
#include <exception>
#include <string>

namespace tandem {

/// What the call throws; empty if nothing.
template <typename Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

}  // namespace tandem
