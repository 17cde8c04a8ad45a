#pragma once

#include <string>
#include <vector>

#include "base/input_error.h"
#include "base/types.h"

namespace palpate {

/// A tool's way through a demo or test: poses over time, relative to a scene's start pose.
struct ToolScript {
  struct Keyframe {
    double time = 0;                                  // s
    double advance = 0;                               // m along the way the tip points
    Eigen::Vector2d slide = Eigen::Vector2d::Zero();  // m along the tool's x and y axes
    double opening = -1;                              // m, of jaws; < 0: as at the start
  };

  std::string name;
  bool from_touch = true;           // advance counts from the first touch of the resting skin, else from the start pose
  bool smooth = true;               // 10 t^3 - 15 t^4 + 6 t^5 between keyframes (at rest at each), else linear
  std::vector<Keyframe> keyframes;  // at least one, times strictly ascending
  SourceLocation end_place;         // of the last keyframe's time, for messages

  /// Time of the last keyframe, s; the tool then stays.
  double duration() const { return keyframes.back().time; }
};

/// Reads a tool script (TOML; the keys are in assets/tools/README.md). Throws InputError with
/// file:line:column.
/// @param tool_radius  m; what `advance_radii` and `slide_radii` are multiples of
ToolScript readToolScript(const std::string& path, double tool_radius);

/// The tool's pose at a time, s. Before a first keyframe that is later than 0 the tool comes
/// from the start pose. Orientation stays the start's.
/// @param first_contact_travel  m from the start pose to first touch (ToolSetUp::first_contact_travel)
Pose poseAt(const ToolScript& script, const Pose& start, double first_contact_travel, double time);

/// How far jaws are open at a time, m. @param start  as at the start
double openingAt(const ToolScript& script, double start, double time);

/// The reference of every key a tool script may have, as Markdown.
std::string toolScriptReference();

}  // namespace palpate
