// Reader of octomap's files.
#pragma once
#include <filesystem>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The occupied leaves of an octree in a file that octomap wrote (`OcTree`): .bt, whose leaves are free or occupied, or
/// .ot, whose leaves have log odds, occupied from 0 on (a probability of a half). `cell_size` is the tree's resolution
/// in metres, the origin is that of its coordinates. No cells where none is occupied, of which there is no Shape.
///
/// Read without octomap. Throws InputError "FILE: byte N: ..." for a file that is missing, cut off, of another tree
/// (ColorOcTree) or deeper than octomap's 16 levels.
Voxels read_octomap_file(const std::filesystem::path& path);

}  // namespace tandem
