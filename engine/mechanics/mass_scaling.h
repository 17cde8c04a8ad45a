#pragma once

#include <vector>

#include "mechanics/critical_time_step.h"

namespace palpate {

/// Masses that allow a longer step, and what they cost.
struct ScaledMass {
  std::vector<double> mass;  // kg (node_count)
  CriticalTimeStep limit;    // with these masses
  double added = 0;          // share of the body's mass
};

/// Selective mass scaling: m_i' = max(m_i, row_i / c), where row_i are the Gershgorin row sums and c is the largest
/// value for which the critical step reaches `dt` (within half a percent above). Mass is added only to nodes that limit
/// the step. Equilibria do not change; motion becomes slower, by about half the share of mass that was added.
/// @param limit  with `mass`; where it reaches dt, nothing is added
/// @param dt     s, wanted
/// Others as in criticalTimeStep. Test: mechanics/mass_scaling_test.cpp
ScaledMass scaleMass(const ShapeTable& shape, const std::vector<double>& volume, const std::vector<int>& point_material,
                     const std::vector<Material>& materials, const std::vector<double>& mass,
                     const NodePatches& patches, const CriticalTimeStep& limit, double dt);

}  // namespace palpate
