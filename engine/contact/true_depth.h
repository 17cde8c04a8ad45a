#pragma once

#include "contact/contact_state.h"
#include "contact/skin.h"
#include "contact/tool_profile.h"

namespace palpate {

/// How deep the tool has pressed the skin: for any shape and pose of the tool, and wherever on the body it is.
///
///   touching:  d = max_s s . n - mean_v X_v . n     s on the tool, n = mean unit normal of the touched skin at rest,
///                                                   into the tissue, or of the tool there: by which d is less (a ball
///                                                   is right by the latter, a flat end by the former), and that of
///                                                   the tool where the tissue has turned
///   in air:    d = -min_v distance(tool, X_v)       the gap to the skin at rest; 0 where that has gone from there
///
/// Means over v are weighted by force and by how near the tool's normals there are to the force: what is under the tip
/// counts, or under the whole face of a flat tool. d is how far the tool's foremost point stands beyond where
/// the skin under it lay at rest: 0 at first touch. The skin's vertices stand for the skin, so d is exact to what the
/// contact itself sees (SkinModel). In air the tissue counts as at rest. (Along the force, which uneven nodes tilt by
/// two degrees, the rim of a flat end of 20 mm radius is 0.7 mm ahead of its middle.)
///
/// Real-time but for the constructor: no allocation, no lock, no throw. Test: contact/true_depth_test.cpp
class TrueDepth {
 public:
  /// The skin must outlive this.
  TrueDepth(const SkinModel& skin, const ToolShape& tool);

  /// m; negative in air: the gap. 0 where there is no skin.
  double of(const Pose& tool, const ContactState& contact) const;

 private:
  double gap(const Pose& tool) const;
  double support(const Vec3& direction) const;

  const SkinModel& skin_;
  std::vector<Vec3f> inwards_;  // (skin vertex_count) unit, into the tissue at rest
  const ToolProfile profile_;
};

}  // namespace palpate
