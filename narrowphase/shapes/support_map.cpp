// Builds the vertex tables of support searches.
#include "shapes/support_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// The edges of the chamber with the signs and the order of |x|, |y|, |z| in `code`; false if no such order exists.
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

std::array<Vec3, 3> octant_edges(unsigned signs) {
  std::array<Vec3, 3> edges;
  for (unsigned k = 0; k < 3; ++k) edges[k] = (signs >> k & 1u ? -1.0 : 1.0) * Vec3::Unit(k);
  return edges;
}

/// The vertices, of some, that are not dominated along all three edges of a cone by the vertex farthest along one of
/// these, or along the cone's centre.
std::vector<std::uint32_t> unbeaten(std::span<const Vec3> vertices, std::span<const std::uint32_t> some,
                                    const std::array<Vec3, 3>& edges, double margin, WorkMeter& meter) {
  meter.spend(1 + static_cast<int>(some.size() / 8));
  const std::array<double, 3> length{edges[0].norm(), edges[1].norm(), edges[2].norm()};
  std::vector<std::array<double, 3>> along(some.size());
  std::array<std::size_t, 4> strong{};
  std::array<double, 4> farthest;
  farthest.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < some.size(); ++i) {
    double sum = 0;
    for (std::size_t e = 0; e < 4; ++e) {
      const double s = e < 3 ? edges[e].dot(vertices[some[i]]) : sum;
      if (e < 3) along[i][e] = s, sum += s / length[e];
      if (s > farthest[e]) farthest[e] = s, strong[e] = i;
    }
  }
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < some.size(); ++i) {
    const bool beaten = std::any_of(strong.begin(), strong.end(), [&](std::size_t j) {
      return along[j][0] > along[i][0] + margin && along[j][1] > along[i][1] + margin &&
             along[j][2] > along[i][2] + margin;
    });
    if (!beaten) kept.push_back(some[i]);
  }
  return kept;
}

}  // namespace

void SupportMap::fill(Block& b, std::span<const Vec3> vertices, std::span<const std::uint32_t> kept) const {
  for (std::size_t l = 0; l < block; ++l) {
    const std::uint32_t i = kept[std::min(l, kept.size() - 1)];
    const auto scaled = [&](int k) { return static_cast<float>((vertices[i][k] - middle_[k]) / unit_); };
    b.x[l] = scaled(0), b.y[l] = scaled(1), b.z[l] = scaled(2);
    b.index[l] = i;
  }
}

SupportMap::SupportMap(std::span<const Vec3> vertices, const Vec3& middle, WorkMeter& meter) : middle_(middle) {
  const std::size_t n = vertices.size();
  Vec3 lo = vertices[0], hi = vertices[0], most = Vec3::Zero();
  for (const Vec3& v : vertices) lo = lo.cwiseMin(v), hi = hi.cwiseMax(v), most = most.cwiseMax(v.cwiseAbs());
  const Vec3 reach = (hi - middle_).cwiseMax(middle_ - lo);
  if (reach.maxCoeff() > 0) unit_ = std::ldexp(1.0, std::ilogb(reach.maxCoeff()));
  for (int k = 0; k < 3; ++k) {
    // Values in double precision are relative to the shape's origin.
    const double rounding = tolerance::support_of_floats * reach[k] + tolerance::support_of_doubles * most[k];
    const double slack = rounding / unit_ + tolerance::clear_of_denormals;
    slack_[static_cast<std::size_t>(k)] = static_cast<float>(tolerance::bound_in_floats * slack);
  }
  const auto append = [&](std::span<const std::uint32_t> kept) {
    const Range range{static_cast<std::uint32_t>(blocks_.size()),
                      static_cast<std::uint32_t>((kept.size() + block - 1) / block)};
    for (std::size_t i = 0; i < kept.size(); i += block)
      fill(blocks_.emplace_back(), vertices, kept.subspan(i, std::min(block, kept.size() - i)));
    return range;
  };
  std::vector<std::uint32_t> kept(n);
  std::iota(kept.begin(), kept.end(), 0u);
  if (n <= searched_all * block) {
    append(kept);
    return;
  }
  // Dominated by more than any rounding of a dot product, so that the answer is that of a scan of all vertices, bit for
  // bit. A vertex dominated over an octant is so in its chambers, too.
  const double margin = 32 * epsilon * most.maxCoeff();
  chambers_.resize(64);
  std::array<std::vector<std::uint32_t>, 8> of_octant;
  for (unsigned signs = 0; signs < 8; ++signs)
    of_octant[signs] = unbeaten(vertices, kept, octant_edges(signs), margin, meter);
  for (unsigned code = 0; code < 64; ++code)
    if (std::array<Vec3, 3> edges; chamber_edges(code, edges))
      chambers_[code] = append(unbeaten(vertices, of_octant[code & 7u], edges, margin, meter));
}

}  // namespace tandem
