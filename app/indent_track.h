#pragma once

#include <vector>

#include "simulation/model.h"

namespace palpate {

/// What the tool does off-screen when no script is given: from its start along its axis
/// to the skin, smoothly on into the tissue, and there it stays. One pose per tick.
/// The depth is half the tool's radius, but at most a tenth of the organ's length along
/// the axis, so that each scene shows a plain indentation that it survives.
std::vector<Pose> indentPoses(const Model& model);

}  // namespace palpate
