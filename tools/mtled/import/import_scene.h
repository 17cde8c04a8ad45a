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
  std::string source;    // the file it came from
  double spacing = 0;    // m
  bool follows = false;  // the cloud follows the tool, and has its own spacings
  bool slowed = true;    // mass is added, so that a tick has fewer steps
  std::vector<HeldBox> held;
  double tool_radius = 0;        // m
  Vec3 tool_tip = Vec3::Zero();  // m
  double tool_max_speed = 0;     // m/s
  Vec3 camera_target = Vec3::Zero();
  double camera_distance = 0;  // m
};

/// Nodes times steps a tick that hold 500 Hz on two cores: the liver of assets/scenes.
inline constexpr double node_steps_budget = 5200;

/// What a body's nodes and steps are counted from before it has any.
struct BodyMeasures {
  double volume = 0, area = 0;  // m^3, m^2
  std::vector<double> depth;    // of points of its inside, spread evenly; m, ascending
  std::vector<double> wall;     // how thick it is below points of its skin, spread evenly; m, ascending
};
BodyMeasures measuresOf(const SurfaceTree& organ);

/// Nodes, and steps of a tick, that a body has with a spacing: within a fifth and a step for most bodies.
double nodesAt(const BodyMeasures& body, double spacing);
int stepsAt(const BodyMeasures& body, double spacing);

/// The spacing with the most nodes whose cost is within the budget.
double firstSpacing(const BodyMeasures& body);

/// Rests on its underside; a ball above its middle.
ImportedScene chooseScene(const SurfaceTree& organ, double spacing);

/// As a scene file, whose surface is surface.obj beside it, in m.
std::string sceneText(const ImportedScene& scene);

}  // namespace palpate::tools
