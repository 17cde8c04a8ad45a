#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mtled/run/scene_spacing.h"

namespace palpate::tools {

/// A variant of a scene: the scene with one setting, or a few, changed.
struct FrontierSetting {
  std::string group;                 // the setting that changes: "spacing", "quadrature", ...
  std::string name;                  // unique: "spacing x 1.3"
  std::function<void(Scene&)> turn;  // changes the scene
  int threads = 0;                   // 0: as many as the scene says
  bool in_double = false;            // computed in double precision, by the batch body
};

/// All settings that a user can change, one at a time and in a few combinations; the first is the scene unchanged.
/// @param places  where the cloud is refined; without, settings with refinement are left out
/// @param quick  only the settings with the largest effect
std::vector<FrontierSetting> frontierSettings(const Scene& scene, const std::vector<ContactRegion>& places, bool quick,
                                              int cores);

}  // namespace palpate::tools
