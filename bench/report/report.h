// Writes results and recordings as one HTML page.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tandem::bench {

/// Writes the page that shows these results and recordings to `out`, one HTML file that needs nothing else; returns a
/// line that summarises its contents. `most_frames`: of a replay. Throws InputError for a file that cannot be used,
/// std::runtime_error if the page's libraries were not available when the program was built, OutputError.
std::string write_report(const std::vector<std::filesystem::path>& files, const std::filesystem::path& out,
                         std::size_t most_frames);

}  // namespace tandem::bench
