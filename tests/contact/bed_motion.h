#pragma once

#include <algorithm>

#include "contact/spring_bed.h"
#include "contact/tools/tool_list.h"

namespace palpate {

// What the tests of contact do with a bed of springs.

inline constexpr int kSubsteps = 10;  // of 0.2 ms: ticks of 2 ms, 500 Hz

inline ToolShape toolOf(ToolKind kind, double radius = 0.01) { return ToolShape::of(kind, radius); }

inline const ToolKind kKinds[] = {ToolKind::Sphere, ToolKind::FlatCylinder, ToolKind::Capsule};

/// A bed whose neighbours are coupled, as tissue's are.
inline SpringBed::Spec tissueLike() {
  SpringBed::Spec spec;
  spec.tension = 10.0;
  spec.skin_spacing = 0.0025;
  return spec;
}

/// Comes to rest quickly.
inline SpringBed::Spec damped(SpringBed::Spec spec) {
  spec.damping = 400.0;
  return spec;
}

/// Stiff to its sides, since the closed forms of a Winkler foundation are those of vertical springs.
inline SpringBed::Spec winkler(double half_width, double node_spacing) {
  SpringBed::Spec spec = damped({});
  spec.half_width = half_width;
  spec.node_spacing = node_spacing;
  spec.skin_spacing = 0.5 * node_spacing;
  spec.lateral = 100.0 * spec.foundation;
  spec.surface_density = 50.0;
  return spec;
}

/// Moves the tool at `velocity` for `ticks`; returns the last force.
inline Vec3 move(SpringBed& bed, const ToolShape& tool, int ticks, const Vec3& velocity, double friction = 0.0) {
  Vec3 force = Vec3::Zero();
  for (int k = 0; k < ticks; ++k) {
    Pose to = bed.pose;
    to.position += kSubsteps * bed.spec.dt * velocity;
    force = bed.tick(tool, to, kSubsteps, friction);
  }
  return force;
}

inline const Vec3 kDown = -Vec3::UnitZ();

inline bool allFinite(const AlignedVector<Float4>& u) {
  return std::all_of(u.begin(), u.end(), [](const Float4& a) { return toVec3(a).allFinite(); });
}

}  // namespace palpate
