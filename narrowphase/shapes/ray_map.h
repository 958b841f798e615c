// Starting points for searches on a hull by direction.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem {

namespace detail {
struct Hull;
}
using detail::Hull;

/// For each of 384 cells of directions, three corners of the face through which the ray from a polytope's interior
/// point through the cell's centre leaves: only a starting point for searches.
class RayMap {
 public:
  using Corners = std::array<std::uint16_t, 3>;

  RayMap() = default;

  bool empty() const { return corners_.empty(); }
  std::size_t memory() const { return corners_.capacity() * sizeof(Corners); }
  const Corners& corners(double dx, double dy, double dz) const { return corners_[cell({dx, dy, dz})]; }

 private:
  friend RayMap map_rays(const Hull& hull);

  static constexpr std::size_t side = 8;  ///< cells along the edge of a cube's face
  static constexpr std::size_t cells = 6 * side * side;

  static std::size_t cell(const std::array<double, 3>& d) {
    const double x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
    const std::size_t k = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
    constexpr std::size_t after[4] = {1, 2, 0, 1};
    const double half = 0.5 * static_cast<double>(side), scale = half / std::abs(d[k]);
    const auto part = [&](double along) {
      return static_cast<std::size_t>(std::min(std::max(0.0, along * scale + half), static_cast<double>(side - 1)));
    };
    return ((2 * k + (d[k] < 0 ? 1 : 0)) * side + part(d[after[k]])) * side + part(d[after[k + 1]]);
  }

  std::vector<Corners> corners_;
};

}  // namespace tandem
