#pragma once

#include "model/model.h"
#include "model/tools_at.h"

namespace palpate {

/// Where a tool comes to stand that should be at `wanted`: before rigid bodies as they are at `time` (s), but those
/// that enclose the organ, a quarter of the nodes' spacing or of its radius off, whichever is less. Thinner tissue
/// between the two is no longer resolved, and was drawn through the body with the tool. It slides along them, and one
/// that moves pushes it out of its way.
///
/// The gap is that of the tool's core, sampled at its corners and between them half a radius apart, each at the side
/// that faces the body.
/// @param farthest  m, that it is pushed back at most
/// Real-time: no allocation, no lock, no throw. Test: simulation/rigid_stop_test.cpp
ToolPosture stoppedByRigidBodies(const Model& model, int tool, const ToolPosture& wanted, double time, double farthest);

/// The same for the tools of a batch solution.
ToolsAt stoppedByRigidBodies(const Model& model, const ToolsAt& wanted, double time);

}  // namespace palpate
