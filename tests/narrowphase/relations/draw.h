// Random pairs for the relations, many of them degenerate.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "posed_pair.h"

namespace tandem::relations {

/// A mesh from a file, with its name.
struct NamedMesh {
  std::string name;
  Mesh mesh;
};

struct DrawOptions {
  std::optional<ShapeKind> a, b;    ///< otherwise any kind; two half-spaces are never drawn
  std::vector<NamedMesh> meshes{};  ///< meshes from files, used as solids if closed, else as surfaces; may be empty
  /// A is a sliver or a long thin hull (`a` is ignored), B is 1e3 to 1e8 times smaller.
  bool needles = false;
  bool rounded = false;  ///< one or both shapes are rounded
  bool unusual = false;  ///< modified by `make_unusual`
  bool deep = false;     ///< B, often much smaller, is about the middle of A
  bool settled = false;  ///< brought to rest by `settle`
  bool slivers = false;  ///< set on a sliver by `set_on_sliver`
};

/// The pair for a seed. Sizes within 1 or ratios up to 1e8; plump shapes, flat and thin ones to 1e-8, points, collinear
/// and sliver triangles, duplicate vertices; poses random, on a grid where touches are exact, with gaps of 1e-16 to
/// 1e-2, concentric, up to 1e8 from the origin.
PosedPair draw_pair(std::uint64_t seed, const DrawOptions& options);

/// One of the 24 rotations that map axes to axes.
Mat3 exact_rotation(Random& r);

/// Moves B along the separating direction until the signed distance is about `gap`.
void place(PosedPair& pair, double gap);

}  // namespace tandem::relations
