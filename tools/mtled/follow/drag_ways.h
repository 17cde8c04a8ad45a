#pragma once

#include <vector>

#include "discretization/surface/surface_tree.h"
#include "mtled/run/scripted_run.h"

namespace palpate::tools {

/// A way of the first tool over an organ: down until it is half a radius deep, then along a straight line as seen along
/// the tool's axis, at that depth below the resting skin.
struct DragWay {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // m, on the resting skin
  double length = 0;                            // m, seen along the axis
  std::vector<Vec3> tip;                        // (sample_count) m, of the drag, evenly spaced along the line
};

struct DragSettings {
  int count = 1;
  double length = 0.06;  // m; shorter where the organ has no room for it, at least half of it
  double speed = 0.03;   // m/s, along the line
  double depth = 0.5;    // tool radii
};

/// Ways where the skin looks at the tool (within 45 degrees) and nothing is imposed, as far apart as can be. Fewer than
/// asked for where there are not so many. The same at each call.
/// @param organ  closed surface, m
std::vector<DragWay> dragWays(const Scene& scene, const SurfaceTree& organ, const DragSettings& settings);

/// The first tool on a way, tick by tick: half a second down from half a radius above, then the drag.
std::vector<ToolPosture> posturesOn(const DragWay& way, const Scene& scene, const DragSettings& settings);

}  // namespace palpate::tools
