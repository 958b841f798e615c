#pragma once
#include <cstddef>
#include <cstdint>

/// What the readers of files take at most. Each bound lies far above what real files need and below what makes a
/// machine with some tens of gigabytes run out of memory; what is beyond one is refused with a message that names it.
namespace tandem::limits {

inline constexpr std::uint64_t mebibyte = 1 << 20;

/// Bytes of a pipe or device that is read as a whole, and of a line that is read at once, so of a pair record too:
/// where it ends is not known before. Two meshes of two million triangles written out take half of it.
inline constexpr std::uint64_t stream_bytes = 512 * mebibyte;

/// Bytes of a JSON document in a regular file (a scene, a bench's result, a timeline): a scene of a million bodies
/// takes a third of it.
inline constexpr std::uint64_t document_bytes = 1024 * mebibyte;

/// Bytes of a mesh in a regular file, and of the buffers that a glTF file names: some 80 million triangles as STL, some
/// 60 million as OBJ. A recording has no bound of its own: it is read step by step.
inline constexpr std::uint64_t mesh_bytes = 4096 * mebibyte;

/// Bytes passed over behind the bound of a line of pair records, in search of its end. What goes on beyond them, as
/// /dev/zero does, is not read further.
inline constexpr std::uint64_t skipped_bytes = 1024 * mebibyte;

/// Arrays and objects within each other in a JSON document; scenes need 7. Copying, comparing and writing a document
/// are recursive, so that this bounds the stack.
inline constexpr std::size_t json_depth = 64;

/// Values of a JSON document, arrays and objects counted: each takes up to some 60 bytes of memory, for 2 to 3 of the
/// text. A scene of a million bodies has 30 million.
inline constexpr std::size_t json_values = std::size_t{1} << 26;

/// Triangles of a mesh file: a face of an OBJ file gives one for each two bytes, and a glTF file may place a mesh many
/// times.
inline constexpr std::size_t mesh_triangles = std::size_t{1} << 27;

/// Vertices of a mesh file: three of their own for each triangle.
inline constexpr std::size_t mesh_vertices = 3 * mesh_triangles;

/// Contacts of a recorded step, of which one is in memory.
inline constexpr std::size_t step_contacts = std::size_t{1} << 26;

/// Lines in succession that are no pair records, after which what is read is taken for something else: an answer to
/// each line of a pipe that never ends would not end either.
inline constexpr std::size_t lines_without_record = 100'000;

/// Bytes of a refusal; with the program's name before it a line stays below 300.
inline constexpr std::size_t message_bytes = 280;

/// Bytes of the value found, as a refusal quotes it.
inline constexpr std::size_t quoted_bytes = 64;

}  // namespace tandem::limits
