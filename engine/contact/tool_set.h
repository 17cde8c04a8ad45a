#pragma once

#include <array>
#include <vector>

#include "base/types.h"
#include "contact/tool.h"

namespace palpate {

inline constexpr int max_tools = 4;                    // of a scene
inline constexpr int max_tool_bodies = 2 * max_tools;  // jaws have two

/// Where a tool is. Jaws: the pose of the middle between the fingers' tips, and the gap between the fingers.
struct ToolPosture {
  Pose pose;
  double opening = 0;  // m; of jaws only
};
using ToolPostures = std::array<ToolPosture, max_tools>;  // the first tool_count count

/// A rigid body that touches: a tool, or one finger of jaws.
struct ToolBody {
  int tool = 0;
  double side = 0;  // jaws: on which side of their middle along their x axis, -1 or 1; 0: the tool itself
  ToolShape shape;
};

/// Where a body is when its tool is there. A finger's side is half the opening from the middle. Real-time.
inline Pose bodyPose(const ToolBody& body, const ToolPosture& tool) {
  Pose pose = tool.pose;
  if (body.side != 0)
    pose.position += pose.orientation * Vec3(body.side * (body.shape.radius + 0.5 * tool.opening), 0, 0);
  return pose;
}

/// A tool of a model.
struct ToolSetUp {
  ToolShape shape;  // of jaws: each finger's
  bool jaws = false;
  ToolPosture start;
  double first_contact_travel = 0;  // m, along its axis from the start to the resting skin; 0: it never touches
  double max_speed = 1;             // m/s
  double max_force = 0;             // N, at which it yields; 0: never
  double grip_force = 0;            // N, jaws: pinch at which they close no further; 0: none
  double friction = 0;              // Coulomb, as loaded; in force is LiveParameters::friction
  std::vector<ToolPosture> path;    // (tick) where its script has it at each tick's end; then it stays. Empty: a hand
};

/// The tools of a model. The first is the one of which forces and depths are told where nothing else is said.
struct ToolSet {
  std::vector<ToolSetUp> tool = std::vector<ToolSetUp>(1);  // (tool_count), at least one
  std::vector<ToolBody> body = std::vector<ToolBody>(1);    // (body_count) by tool

  const ToolSetUp& first() const { return tool[0]; }
  ToolSetUp& first() { return tool[0]; }
  int toolCount() const { return static_cast<int>(tool.size()); }
  int bodyCount() const { return static_cast<int>(body.size()); }
  /// Several tools, or jaws: files and readings have them one by one.
  bool several() const { return body.size() > 1; }
};

/// What the tissue does to a tool.
struct ToolLoad {
  Vec3 force = Vec3::Zero();                   // N, on the tool; jaws: both fingers'
  Vec3 torque = Vec3::Zero();                  // N m, about its tip; of a whole tick only
  double pinch = 0;                            // N, jaws: mean of what presses the two fingers apart
  double work = 0;                             // J, of a step or tick, that it has done on the tissue by moving
  int contact_count = 0;                       // points of the skin that carry force
  int near_count = 0;                          // skin vertices that it may reach in the tick; of a whole tick only
  bool stopped = false;                        // it stands before what is rigid (RigidStop); likewise
  double expected_error = 0, error_force = 0;  // as StepReport's, of this tool's force; likewise
};
using ToolLoads = std::array<ToolLoad, max_tools>;

}  // namespace palpate
