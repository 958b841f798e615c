#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tandem::bench {

/// Writes the page that shows these results and recordings to `out`, one HTML file that needs nothing else; returns a
/// line that says what it holds. `most_frames`: of a replay. Throws InputError for a file that cannot be used,
/// std::runtime_error when the page's libraries were not to be had when the program was built, OutputError.
std::string write_report(const std::vector<std::filesystem::path>& files, const std::filesystem::path& out,
                         std::size_t most_frames);

}  // namespace tandem::bench
