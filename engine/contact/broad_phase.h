#pragma once

#include "contact/contact_state.h"
#include "contact/skin.h"
#include "contact/tool.h"

namespace palpate {

/// What the tissue itself may travel towards the tool between two searches, per tool radius.
/// Smaller: a rebounding vertex enters up to a tick late, with a jump in the force.
/// Larger: more candidates, each two interpolations per step.
constexpr double kTissueTravel = 0.1;

/// Finds the skin vertices whose distance to the tool is at most `margin` + kTissueTravel R (regions
/// and clusters first, with bounds that allow for the tissue's stretch) and lists them in `contact` by ascending
/// vertex, keeping the warm-start forces of those that stay. Where faces near the tool are stretched, the reach grows
/// with their edges (face_samples.h). Once per tick. A vertex that is not
/// finite is never listed.
/// @param margin  m; what the tool travels until the next call (largestTravel), seen from `tool_pose`
/// @pre  no vertex of a region or cluster is further from its representative than twice the reference distance (or than
/// the largest stretch near the tool);
///       beyond that stretch a vertex may be listed late, when the representative has come closer.
/// Real-time: no allocation, no lock, no throw; cost ~ one interpolation per region, per
/// cluster of the regions in reach and per vertex of the clusters in reach.
/// Test: contact/broad_phase_test.cpp (against all vertices).
void findContactCandidates(const SkinModel& skin, const Float4* u, const ToolShape& tool, const Pose& tool_pose,
                           double margin, ContactState& contact, ContactScratch& scratch);

}  // namespace palpate
