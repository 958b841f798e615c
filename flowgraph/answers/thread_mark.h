// An identifier of the calling thread.
#pragma once

namespace tandem {

/// A number that differs between any two threads that are running: the address of a thread-local variable.
inline const void* this_thread_mark() {
  static thread_local const char mark = 0;
  return &mark;
}

}  // namespace tandem
