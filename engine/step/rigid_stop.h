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
///   rigid bodies           but those that enclose the organ, as they are from `time` - `duration` to `time`: the tool
///                          slides along them, and one that moves pushes it out of its way, as far as it goes, also
///                          through what holds the organ. The gap is that of the tool's core, sampled at its corners
///                          and between them half a radius apart, each at the side that faces the body.
///
/// The way is that of a tick: what holds the organ further off than it is long, and the clearance, is not seen.
struct RigidStop {
  double time = 0;                                            // s
  double duration = 0;                                        // s, of the tick; 0: rigid bodies are where they end
  double farthest = std::numeric_limits<double>::infinity();  // m, that rigid bodies that stand push it back at most
  BoundaryShifts shifts{};                                    // of what holds the organ

  /// To the bit `wanted` where nothing is in the way. Real-time: no allocation, no lock, no throw.
  /// Test: simulation/rigid_stop_test.cpp
  ToolPosture of(const Model& model, int tool, const ToolPosture& from, const ToolPosture& wanted) const;
  /// Its two halves, in this order.
  ToolPosture beforeHeld(const Model& model, int tool, const ToolPosture& from, const ToolPosture& wanted) const;
  ToolPosture amongRigid(const Model& model, int tool, const ToolPosture& from, const ToolPosture& wanted) const;

  /// Whether a tool is in a rigid body all the same: between two, or jaws about one. Real-time.
  bool failsAt(const Model& model, int tool, const ToolPosture& posture) const;

  /// Whether a rigid body, not the hand, bears most of a force on a tool (N). Real-time.
  bool bears(const Model& model, int tool, const ToolPosture& posture, const Vec3& force) const;
};

/// Throws InputError where a tool starts inside a rigid body that does not enclose the organ.
void checkToolStarts(const Model& model);

/// RigidStop::of for the tools of a batch solution, whose ways may be long: what holds the organ stops them along all
/// of it, then rigid bodies do. @param duration  as RigidStop's
ToolsAt stoppedByRigid(const Model& model, const ToolsAt& from, const ToolsAt& wanted, double time,
                       double duration = 0);

}  // namespace palpate
