#pragma once

#include <limits>

#include "model/model.h"
#include "model/tools_at.h"

namespace palpate {

/// Where a tool comes to stand on its way `from` .. `wanted`: before what is rigid, a quarter of the nodes' spacing off
/// (from rigid bodies a quarter of its radius, if that is less). Thinner tissue between the two is no longer resolved,
/// and was drawn through the body, or between the held nodes, with the tool.
///
///   what holds the organ   (HeldTissue) stops tools that are on its inner side, under the hand; a hand that draws
///                          sideways slides them along. From outside they meet it as any skin, by contact, and what
///                          they have passed that way holds them no more. One that begins nearer may leave. Turns and
///                          opening jaws are not looked at.
///   rigid bodies           but those that enclose the organ, as they are at `time`: the tool slides along them, and
///                          one that moves pushes it out of its way. The gap is that of the tool's core, sampled at its
///                          corners and between them half a radius apart, each at the side that faces the body.
///
/// The way is that of a tick: what lies further off than it is long, and the clearance, is not seen.
struct RigidStop {
  double time = 0;                                            // s
  double farthest = std::numeric_limits<double>::infinity();  // m, that a rigid body pushes it back at most
  BoundaryShifts shifts{};                                    // of what holds the organ

  /// To the bit `wanted` where nothing is in the way. Real-time: no allocation, no lock, no throw.
  /// Test: simulation/rigid_stop_test.cpp
  ToolPosture of(const Model& model, int tool, const ToolPosture& from, const ToolPosture& wanted) const;
};

/// Throws InputError where a tool starts inside a rigid body that does not enclose the organ.
void checkToolStarts(const Model& model);

/// RigidStop::of for the tools of a batch solution, whose ways may be long: what holds the organ stops them along all
/// of it, rigid bodies where it ends.
ToolsAt stoppedByRigid(const Model& model, const ToolsAt& from, const ToolsAt& wanted, double time);

}  // namespace palpate
