#pragma once

#include <algorithm>

#include "contact/tools/tool_list.h"
#include "discretization/surface/solids.h"
#include "setup/build_model.h"
#include "support/small_scene.h"

namespace palpate::test {

/// A strip, 8 mm thin and 24 mm high, that stands on a table (tool 2) between jaws (tool 1).
/// One end is guided; it moves freely up and down, so that table and jaws bear all of its weight.
inline Scene stripScene() {
  Scene scene;
  scene.name = "strip";
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3(0.008, 0.03, 0.024);
  scene.discretization.spacing = 0.004;
  scene.materials.emplace_back();
  scene.materials[0].material = Material::neoHookean(5000, 0.45, 1050);
  scene.boundaries = {planeBoundary(Vec3(0, -0.015, 0), Vec3::UnitY(), {true, true, false})};
  scene.dynamics.gravity = Vec3(0, 0, -9.81);
  scene.dynamics.damping = 60;
  scene.tools[0].shape = ToolShape::of(ToolKind::Capsule, 0.004, 0.03);
  scene.tools[0].position = Vec3(0, 0, 0.012);
  scene.tools[0].opening = 0.012;
  scene.tools[0].max_speed = 0.2;
  scene.tools[0].friction = 0.8;
  ToolSpec table;
  table.shape = ToolShape::of(ToolKind::FlatCylinder, 0.03, 0.01);
  table.position = Vec3(0, 0, -0.0003);
  table.direction = Vec3::UnitZ();
  table.friction = 0.5;
  scene.tools.push_back(table);
  return scene;
}

inline Model stripModel(const Scene& scene = stripScene()) {
  return buildModel(scene, boxSurface(scene.organs[0].size, 0.004));
}

/// N, of the strip.
inline double stripWeight(const Model& model) {
  double weight = 0;
  for (const Double4& w : model.weight) weight -= w.z;
  return weight;
}

/// The jaws after `seconds`: they wait for the strip to stand, close on it, and lift it by 10 mm.
inline ToolPosture graspAndLift(const Model& model, double seconds) {
  const auto share = [&](double from, double to) { return std::clamp((seconds - from) / (to - from), 0.0, 1.0); };
  ToolPosture jaws{model.tools.first().start.pose, 0.012 - 0.007 * share(0.2, 0.5)};
  jaws.pose.position.z() += 0.01 * share(0.6, 1.0);
  return jaws;
}

}  // namespace palpate::test
