#pragma once

#include <string>
#include <vector>

#include "discretization/surface/surface_tree.h"

namespace palpate::tools {

/// A part of space that is held: the underside of one part of the organ.
struct HeldBox {
  Vec3 min, max;  // m
};

/// What an imported organ's scene says that depends on the organ.
struct ImportedScene {
  std::string name;
  std::string source;  // the file it came from
  double spacing = 0;  // m
  std::vector<HeldBox> held;
  double tool_radius = 0;        // m
  Vec3 tool_tip = Vec3::Zero();  // m
  double tool_max_speed = 0;     // m/s
  Vec3 camera_target = Vec3::Zero();
  double camera_distance = 0;  // m
};

/// Nodes times steps a tick that hold 500 Hz on two cores: the liver of assets/scenes.
inline constexpr double node_steps_budget = 5200;

/// The spacing with the most nodes in the budget, as far as volume and area tell before nodes are made: half the
/// spacing takes half the step.
double firstSpacing(double volume, double area);

/// Rests on its underside; a ball above its middle.
ImportedScene chooseScene(const SurfaceTree& organ, double spacing);

/// As a scene file, whose surface is surface.obj beside it, in m.
std::string sceneText(const ImportedScene& scene);

}  // namespace palpate::tools
