#pragma once
#include <span>
#include <string_view>

#include "exact_impact.h"
#include "random.h"
#include "tandem/narrowphase/vertex_impact.h"

namespace tandem::reference {

/// A kind of queries: its name, and a maker of one.
struct ImpactFamily {
  std::string_view name;
  ImpactQuery (*make)(Random& random);
};

/// What continuous collision detection is asked in simulations, and what it fails at: motions in a plane, none at all,
/// touches at t = 0 and t = 1, features without extent, vertices in one place, parallel edges, vertices on edges,
/// spikes, wedges and cliffs, large turns. After the kinds of queries of Wang, Ferguson, Schneider, Jiang, Attene,
/// Panozzo, A Large Scale Benchmark and an Inclusion-Based Algorithm for Continuous Collision Detection, ACM
/// Transactions on Graphics 2021, and the scenes of Erleben, Methodology for Assessing Mesh-Based Contact Point
/// Methods, 2018.
std::span<const ImpactFamily> impact_families();

/// What tandem answers.
VertexImpact solve(const ImpactQuery& query, const ImpactOptions& options = {});

/// The longest way that a vertex of one feature makes as a vertex of the other sees it: the unit of the tolerance.
double longest_motion(const ImpactQuery& query);

}  // namespace tandem::reference
