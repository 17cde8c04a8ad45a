#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mtled/run/scripted_run.h"

namespace palpate::tools {

/// One way to set a scene: its own settings with something turned.
struct FrontierSetting {
  std::string group;                 // what is turned: "spacing", "quadrature", ...
  std::string name;                  // unlike all others: "spacing x 1.3"
  std::function<void(Scene&)> turn;  // does it
  int threads = 0;                   // 0: the scene's
  bool in_double = false;            // by the batch body
};

/// The part of the body that a tool's way works on.
struct ContactRegion {
  Vec3 centre = Vec3::Zero();  // m
  double radius = 0;           // m; 0: the tool stays away from the organ
};
/// A sphere around the places of the skin that the way's tool tip comes near to, two tool radii wider.
ContactRegion contactRegion(const Model& model, const ToolTrajectory& way);

/// `outside` times the scene's spacing, and `inside` times it where the tool works.
void refineWhere(Scene& scene, const ContactRegion& place, double outside, double inside);

/// All that a user can turn, one thing at a time and in a few combinations; the first is the scene as it is.
/// @param place  where refinement is worth it; of radius 0: such settings are left out
/// @param quick  the most telling ones only
std::vector<FrontierSetting> frontierSettings(const Scene& scene, const ContactRegion& place, bool quick, int cores);

/// The scene's settings with spacing and refinements `factor` times as wide.
void scaleSpacing(Scene& scene, double factor);

}  // namespace palpate::tools
