#pragma once

#include "step/tool_bodies.h"
#include "support/small_scene.h"

namespace palpate::test {

/// A block that may slide along x, and a fingertip on each side of it, 3 mm away.
inline Scene squeezedScene() {
  Scene scene = blockScene(0.0075);
  scene.organs[0].size = Vec3(0.03, 0.03, 0.03);
  scene.boundaries[0].component[0] = false;
  scene.tools[0].shape.radius = 0.007;
  scene.tools[0].position = Vec3(0.018, 0, 0.017);
  scene.tools[0].direction = -Vec3::UnitX();
  scene.tools[0].friction = 0.3;
  ToolSpec other;
  other.shape = scene.tools[0].shape;
  other.position = Vec3(-0.018, 0, 0.017);
  other.direction = Vec3::UnitX();
  other.friction = 0.3;
  scene.tools.push_back(other);
  return scene;
}

/// Both fingers `depth` m in the block.
inline Command fingersAt(const Model& model, double depth) {
  Command command = restCommand(model);
  command.tools[0].pose.position.x() -= 0.003 + depth;
  command.tools[1].pose.position.x() += 0.003 + depth;
  return command;
}

}  // namespace palpate::test
