// Limits on the size of input files, and on the numbers in them.
#pragma once
#include <cstddef>
#include <cstdint>

/// Upper limits of what the readers of files accept. Each lies far above what real files need and below what makes a
/// machine with some tens of gigabytes run out of memory; what exceeds one is refused with a message that names it.
namespace tandem::limits {

inline constexpr std::uint64_t mebibyte = 1 << 20;

/// Bytes of a pipe or device that is read as a whole, and of a single line, such as a pair record: its end is not known
/// before. Two meshes of two million triangles written out take half of it.
inline constexpr std::uint64_t stream_bytes = 512 * mebibyte;

/// Bytes of a JSON document in a regular file (a scene, a bench's result, a timeline): a scene of a million bodies
/// takes a third of it.
inline constexpr std::uint64_t document_bytes = 1024 * mebibyte;

/// Bytes of a mesh in a regular file, and of the buffers that a glTF file names: some 80 million triangles as STL, some
/// 60 million as OBJ. A recording has no bound of its own: it is read step by step.
inline constexpr std::uint64_t mesh_bytes = 4096 * mebibyte;

/// Bytes that are skipped behind the limit of a line of pair records, in search of its end. A line that continues
/// beyond them, as /dev/zero does, is not read further.
inline constexpr std::uint64_t skipped_bytes = 1024 * mebibyte;

/// Nesting depth of arrays and objects in a JSON document; scenes need 7. Copying, comparing and writing a document are
/// recursive, so this bounds the stack.
inline constexpr std::size_t json_depth = 64;

/// Values of a JSON document, arrays and objects included: each takes up to some 60 bytes of memory, for 2 to 3 bytes
/// of text. A scene of a million bodies has 30 million.
inline constexpr std::size_t json_values = std::size_t{1} << 26;

/// Triangles of a mesh file: a face of an OBJ file can give one for each two bytes of text, and a glTF file may use a
/// mesh many times.
inline constexpr std::size_t mesh_triangles = std::size_t{1} << 27;

/// Vertices of a mesh file: three for each triangle. Also the corners of all uses of a glTF file's meshes, together.
inline constexpr std::size_t mesh_vertices = 3 * mesh_triangles;

/// Members of an object in the lists of a glTF file, which one after the other are compared with a name; the format has
/// some twenty for each kind. Many others may refer to one.
inline constexpr std::size_t gltf_members = 1000;

/// Components of velocities (m/s, rad/s) and of gravity (m/s^2) in a scene file, so that the numbers of a simulation
/// remain finite.
inline constexpr double fastest = 1e9;
/// The permitted components, for messages.
inline constexpr const char* component_range = "at most 1e9 in size";

/// Densities in a scene file, kg/m^3: masses remain finite.
inline constexpr double densest = 1e15;
/// The permitted densities, for messages.
inline constexpr const char* density_range = "> 0, at most 1e15 kg/m^3";

/// Contacts of a recorded step; one step is held in memory.
inline constexpr std::size_t step_contacts = std::size_t{1} << 26;

/// Consecutive lines that are no pair records, after which the input is rejected as another kind of file: otherwise the
/// answers to an endless pipe would be endless, too.
inline constexpr std::size_t lines_without_record = 100'000;

/// Bytes of an error message; with the program's name before it a line stays below 300.
inline constexpr std::size_t message_bytes = 280;

/// Bytes of the value found, as an error message quotes it.
inline constexpr std::size_t quoted_bytes = 64;

}  // namespace tandem::limits
