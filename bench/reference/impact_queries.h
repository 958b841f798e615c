// Families of queries for continuous collision detection of vertices on straight lines.
#pragma once
#include <span>
#include <string_view>

#include "exact_impact.h"
#include "random.h"
#include "tandem/narrowphase/vertex_impact.h"

namespace tandem::reference {

/// A family of queries: its name, and a function that makes one.
struct ImpactFamily {
  std::string_view name;
  ImpactQuery (*make)(Random& random);
};

/// Queries as simulations have them, and those at which continuous collision detection fails: motions in a plane, no
/// motion, contact at t = 0 and t = 1, degenerate features, coincident vertices, parallel edges, vertices on edges,
/// spikes, wedges and cliffs, large rotations. After Wang, Ferguson, Schneider, Jiang, Attene, Panozzo, A Large Scale
/// Benchmark and an Inclusion-Based Algorithm for Continuous Collision Detection, ACM Transactions on Graphics 2021,
/// and the scenes of Erleben, Methodology for Assessing Mesh-Based Contact Point Methods, 2018.
std::span<const ImpactFamily> impact_families();

/// The answer of tandem.
VertexImpact solve(const ImpactQuery& query, const ImpactOptions& options = {});

/// The longest motion of a vertex of one feature relative to a vertex of the other: the unit of the tolerance.
double longest_motion(const ImpactQuery& query);

}  // namespace tandem::reference
