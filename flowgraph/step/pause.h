// The pause instruction of spin loops.
#pragma once
#include <thread>

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace tandem {

/// The body of a loop that waits for another thread's write: lets the core's other hardware thread go first.
inline void pause() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#else
  std::this_thread::yield();
#endif
}

}  // namespace tandem
