#pragma once
#include <string>
#include <string_view>

namespace tandem::test {

/// Gives the bytes to a reader of files: pair_record, scene, obj, stl, ply, off, gltf, glb, recording or results. Empty, or what is wrong:
/// an exception that is no InputError, a refusal that is not one line of valid UTF-8 under 300 characters, or something
/// that was accepted and, written again, is read as something else.
std::string judge_reader(std::string_view reader, std::string_view bytes);

}  // namespace tandem::test
