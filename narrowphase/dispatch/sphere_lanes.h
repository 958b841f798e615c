// Spheres with spheres and half-spaces, a pair a lane.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "boxes/answer_rows.h"
#include "boxes/halfspace_boxes.h"
#include "tandem/narrowphase/several_pairs.h"

namespace tandem {

struct SpherePair {
  PlacedSphere a, b;
};
struct HalfspaceSphere {
  const PlacedHalfspace* halfspace;
  PlacedSphere sphere;
};

/// Results, a pair a column, in the caller's order.
struct SphereFindings {
  static constexpr std::size_t most = 96;
  enum Finding : std::uint8_t {
    apart,     ///< by more than the margin
    touching,  ///< or nearly so
    unknown    ///< to be solved separately: rounding decides, or the centres coincide
  };
  Finding finding[most];
  AnswerRows<most> answers;
  ContactRows<most> contacts;

  /// Appends pair k's answer under this number; false if it is unknown.
  bool append(std::size_t k, std::size_t number, std::vector<Contact>& to, AnswerSink& sink) const;
};

/// As SeveralPairs::near.
std::uint32_t near_spheres(std::span<const PlacedSpheres> pairs, double margin);

/// As SeveralPairs::solve_spheres.
SpheresSolved solve_spheres(std::span<const PlacedSpheres> pairs, double margin, const AnswerPlaces& to);

/// Signed distances and contacts of several pairs at once, at most `SphereFindings::most`, a pair a lane; the same bits
/// as one by one.
void find_on_spheres(std::span<const SpherePair> pairs, double margin, SphereFindings& found);
void find_spheres_on_halfspaces(std::span<const HalfspaceSphere> pairs, double margin, SphereFindings& found);

}  // namespace tandem
