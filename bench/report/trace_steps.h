#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "formats/json_reader.h"

namespace tandem::bench {

/// From a timeline as `tandem run --trace` writes it, at most eight steps: the first, the last, the longest, the median
/// one and some between. Times in us. {file, threads, recorded_steps, steps: [{step, length, slices: [[thread, name,
/// begin, duration, pairs]...], queue: [[time, batches]...], notes: [...]}]}. Throws InputError.
Json trace_steps(const JsonRef& document, const std::string& file);

}  // namespace tandem::bench
