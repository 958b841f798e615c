// C++ sources without comments and texts, for tests that read sources.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// The source with comments and quoted texts as blanks: all other characters keep their positions, and so do line ends.
std::string code_only(std::string_view text);

/// The headers and sources in folders of a root, as far as these exist, by their relative path, sorted.
std::vector<std::filesystem::path> sources(const std::filesystem::path& root, const std::vector<std::string>& folders);

/// The text of a file. Throws std::runtime_error if it cannot be read.
std::string text_of(const std::filesystem::path& file);
