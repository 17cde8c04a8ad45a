#pragma once

#include "contact/contact_state.h"
#include "contact/skin.h"
#include "contact/tool.h"

namespace palpate {

/// Finds the skin vertices within `margin` of the tool (clusters first, with bounds
/// that allow for the tissue's stretch) and lists them in `contact` by ascending vertex, keeping
/// the warm-start forces of those that stay. Once per tick. A non-finite vertex is never listed.
/// @param margin  m; at least what tool (largestTravel) and tissue travel until the next call
/// @pre  no two vertices of a cluster are further apart than twice their reference distance;
///       beyond that stretch a vertex may be listed late, when its cluster's centre has come closer.
/// Real-time: no allocation, no lock, no throw; cost ~ one interpolation per cluster and
/// one per vertex of the clusters in reach.
/// Test: contact/broad_phase_test.cpp (against all vertices).
void findContactCandidates(const SkinModel& skin, const Float4* u, const ToolShape& tool,
                           const Pose& tool_pose, double margin, ContactState& contact);

}  // namespace palpate
