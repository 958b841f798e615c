// Four floats as a vector, with the baseline instructions of an architecture: for loops that process one triangle or
// box at a time, where wider vectors do not help. Arithmetic is per lane and never fused: the same bits everywhere.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace tandem {

using FourFloats = float __attribute__((vector_size(16)));

inline FourFloats all_four(float x) { return FourFloats{x, x, x, x}; }
inline FourFloats load_four(const float* from) {
  FourFloats v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
inline void store_four(FourFloats v, float* to) { std::memcpy(to, &v, sizeof v); }
#ifdef __SSE2__  // compilers do not always see that it is one instruction
inline FourFloats min_of(FourFloats a, FourFloats b) { return _mm_min_ps(a, b); }
inline FourFloats max_of(FourFloats a, FourFloats b) { return _mm_max_ps(a, b); }
#else
inline FourFloats min_of(FourFloats a, FourFloats b) { return a < b ? a : b; }
inline FourFloats max_of(FourFloats a, FourFloats b) { return a > b ? a : b; }
#endif
inline FourFloats absolute(FourFloats v) { return max_of(v, -v); }
/// Truncates towards 0; the values must fit.
inline std::array<std::int32_t, 4> to_integers(FourFloats v) {
  using FourIntegers = std::int32_t __attribute__((vector_size(16)));
  const FourIntegers whole = __builtin_convertvector(v, FourIntegers);
  return {whole[0], whole[1], whole[2], whole[3]};
}

}  // namespace tandem
