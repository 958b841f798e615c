#include "support_map.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace tandem {
namespace {

/// The edges of the chamber with the signs and the order of |x|, |y|, |z| in `code`; false where no such order exists.
bool chamber_edges(unsigned code, std::array<Vec3, 3>& edges) {
  const bool xy = code & 8u, yz = code & 16u, zx = code & 32u;
  if (xy && yz && zx) return false;
  // With ties, x > y, y > z, z > x can all be false: only on planes between chambers, where |x| = |y| = |z|.
  const int above_x = (xy ? 0 : 1) + (zx ? 1 : 0), above_y = (xy ? 1 : 0) + (yz ? 0 : 1);
  const int above_z = (yz ? 1 : 0) + (zx ? 0 : 1);
  const bool diagonal = !xy && !yz && !zx;
  const int rank[3] = {above_x, above_y, above_z};
  for (int e = 0; e < 3; ++e)
    for (int k = 0; k < 3; ++k)
      edges[static_cast<std::size_t>(e)][k] = diagonal || rank[k] <= e ? (code >> k & 1u ? -1.0 : 1.0) : 0.0;
  return true;
}

}  // namespace

SupportMap::SupportMap(std::span<const Vec3> vertices) {
  const std::size_t n = vertices.size();
  const auto append = [&](std::vector<std::uint32_t>& kept) {
    const std::size_t blocks = (kept.size() + block - 1) / block;
    const Range range{static_cast<std::uint32_t>(index_.size() / block), static_cast<std::uint32_t>(blocks)};
    kept.resize(blocks * block, kept.back());
    for (std::size_t b = 0; b < blocks; ++b)
      for (int k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < block; ++l) xyz_.push_back(vertices[kept[b * block + l]][k]);
    index_.insert(index_.end(), kept.begin(), kept.end());
    return range;
  };
  std::vector<std::uint32_t> kept(n);
  std::iota(kept.begin(), kept.end(), 0u);
  if (n <= block) {
    chambers_.fill(append(kept));
    return;
  }
  double reach = 0;
  for (const Vec3& v : vertices) reach = std::max(reach, v.cwiseAbs().maxCoeff());
  // Beaten by more than any rounding of a dot product: the answer is that of a scan of all vertices, bit for bit.
  const double margin = 32 * std::numeric_limits<double>::epsilon() * reach;
  std::vector<std::array<double, 3>> along(n);
  for (unsigned code = 0; code < 64; ++code) {
    std::array<Vec3, 3> edges;
    if (!chamber_edges(code, edges)) continue;
    std::array<std::size_t, 4> strong{};  // the best along the edges and along the middle of the chamber
    std::array<double, 4> most;
    most.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t e = 0; e < 4; ++e) {
        const double s = e < 3 ? edges[e].dot(vertices[i]) : sum;
        if (e < 3) along[i][e] = s, sum += s / edges[e].norm();
        if (s > most[e]) most[e] = s, strong[e] = i;
      }
    }
    kept.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const bool beaten = std::any_of(strong.begin(), strong.end(), [&](std::size_t j) {
        return along[j][0] > along[i][0] + margin && along[j][1] > along[i][1] + margin &&
               along[j][2] > along[i][2] + margin;
      });
      if (!beaten) kept.push_back(static_cast<std::uint32_t>(i));
    }
    chambers_[code] = append(kept);
  }
}

}  // namespace tandem
