#pragma once

#include <array>
#include <vector>

#include "simulation/preparation.h"

namespace palpate {

/// The integration points around each node, a group for each material there: what resolution.h takes means over.
struct PointGroups {
  std::vector<std::array<int, 4>> of_point;  // (point_count) groups at the nodes of its cell
  std::vector<float> inverse_volume;         // (group_count) 1/m^3, of the group's points
};
PointGroups makePointGroups(const Preparation& preparation);

}  // namespace palpate
