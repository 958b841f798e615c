// The message of an exception.
#pragma once
#include <exception>
#include <string>

namespace tandem {

/// The message of the exception that the call throws; empty if none.
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
