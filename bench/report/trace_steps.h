// The steps of a timeline, for the page's drawing.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "formats/json_reader.h"

namespace tandem::bench {

/// At most eight steps of a timeline of `tandem run --trace`: the first, the last, the longest, the median one and some
/// between. Times in us. {file, threads, recorded_steps, steps: [{step, length, slices: [[thread, name, begin,
/// duration, pairs]...], queue: [[time, batches]...], notes: [...]}]}. Throws InputError.
Json trace_steps(const JsonRef& document, const std::string& file);

}  // namespace tandem::bench
