// Checks readers of files on arbitrary bytes.
#pragma once
#include <string>
#include <string_view>

namespace tandem::test {

/// Gives the bytes to a reader of files: pair_record, scene, obj, stl, ply, off, gltf, glb, octomap, recording or
/// results. Returns what is wrong, or nothing: an exception other than InputError, a message that is not one line of
/// valid UTF-8 under 300 characters, or an accepted input that, written again, is read differently.
std::string judge_reader(std::string_view reader, std::string_view bytes);

}  // namespace tandem::test
