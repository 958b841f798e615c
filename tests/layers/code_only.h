// A C++ source without what the compiler does not read as code: for tests that read sources.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// The text with comments and what stands between quotes as blanks: every other character stays where it was, and so do
/// the ends of lines.
std::string code_only(std::string_view text);

/// The headers and sources in folders of a root, those that it has, by their path from there, in order.
std::vector<std::filesystem::path> sources(const std::filesystem::path& root, const std::vector<std::string>& folders);

/// What a file says. Throws std::runtime_error if it cannot be read.
std::string text_of(const std::filesystem::path& file);
