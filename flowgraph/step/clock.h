// The clock by which steps are measured, and its units.
#pragma once
#include <chrono>
#include <cstdint>

namespace tandem {

using Clock = std::chrono::steady_clock;

inline std::int64_t to_ns(Clock::duration d) { return std::chrono::duration_cast<std::chrono::nanoseconds>(d).count(); }
inline double to_ms(std::int64_t ns) { return 1e-6 * static_cast<double>(ns); }
inline double to_ms(Clock::duration d) { return to_ms(to_ns(d)); }

}  // namespace tandem
