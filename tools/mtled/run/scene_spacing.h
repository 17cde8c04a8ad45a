#pragma once

#include "mtled/run/scripted_run.h"

namespace palpate::tools {

/// The part of the body that a tool, or one finger of jaws, deforms on its trajectory.
struct ContactRegion {
  Vec3 centre = Vec3::Zero();  // m
  double radius = 0;           // m
};
/// For each that comes near to the skin, a sphere around all places of it that its tip does, widened by two tool radii.
std::vector<ContactRegion> contactRegions(const Model& model, const ToolTrajectory& way);

/// Sets the spacing to `inside` times the scene's in the regions of contact, and to `outside` times it elsewhere.
void refineWhere(Scene& scene, const std::vector<ContactRegion>& places, double outside, double inside);

/// Where its cloud follows the tool, the scene with nodes evenly apart, 1.3 times as far as in the ball; others as they
/// are.
Scene uniformScene(Scene scene);

/// The scene's settings with spacing and refinements `factor` times as wide; where the cloud follows the tool, with
/// nodes as much further apart, and its refinements as they are.
void scaleSpacing(Scene& scene, double factor);

}  // namespace palpate::tools
