#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mtled/run/scripted_run.h"

namespace palpate::tools {

/// A variant of a scene: the scene with one setting, or a few, changed.
struct FrontierSetting {
  std::string group;                 // the setting that changes: "spacing", "quadrature", ...
  std::string name;                  // unique: "spacing x 1.3"
  std::function<void(Scene&)> turn;  // changes the scene
  int threads = 0;                   // 0: as many as the scene says
  bool in_double = false;            // computed in double precision, by the batch body
};

/// The part of the body that a tool deforms on its trajectory.
struct ContactRegion {
  Vec3 centre = Vec3::Zero();  // m
  double radius = 0;           // m; 0: the tool stays away from the organ
};
/// A sphere around all places of the skin that the tool's tip comes near to, widened by two tool radii.
ContactRegion contactRegion(const Model& model, const ToolTrajectory& way);

/// Sets the spacing to `inside` times the scene's in the region of contact, and to `outside` times it elsewhere.
void refineWhere(Scene& scene, const ContactRegion& place, double outside, double inside);

/// All settings that a user can change, one at a time and in a few combinations; the first is the scene unchanged.
/// @param place  where the cloud is refined; if its radius is 0, settings with refinement are left out
/// @param quick  only the settings with the largest effect
std::vector<FrontierSetting> frontierSettings(const Scene& scene, const ContactRegion& place, bool quick, int cores);

/// Where its cloud follows the tool, the scene with nodes evenly apart, 1.3 times as far as in the ball; others as they
/// are.
Scene uniformScene(Scene scene);

/// The scene's settings with spacing and refinements `factor` times as wide.
void scaleSpacing(Scene& scene, double factor);

}  // namespace palpate::tools
