// Random pairs for the relations, degenerate on purpose.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "posed_pair.h"

namespace tandem::relations {

/// A mesh from a file and its name.
struct NamedMesh {
  std::string name;
  Mesh mesh;
};

struct DrawOptions {
  std::optional<ShapeKind> a, b;    ///< else any; two half-spaces are never drawn
  std::vector<NamedMesh> meshes{};  ///< real ones, taken as solids where they close and as surfaces; may be empty
  bool needles = false;             ///< A a sliver or a long thin hull (`a` is not asked), B 1e3 to 1e8 times smaller
  bool rounded = false;             ///< one shape or both with a ball about each point
  bool unusual = false;             ///< changed by `make_unusual`
};

/// The pair of a seed. Sizes within 1 or ratios up to 1e8, plump, flat and thin to 1e-8,
/// points, collinear and sliver triangles, duplicated vertices; poses random, on a grid where touches are exact,
/// touching to 1e-16 to 1e-2, concentric, as far out as 1e8.
PosedPair draw_pair(std::uint64_t seed, const DrawOptions& options);

/// Moves B along the separating direction until the signed distance is about `gap`.
void place(PosedPair& pair, double gap);

}  // namespace tandem::relations
