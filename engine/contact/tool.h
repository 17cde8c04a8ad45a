#pragma once

#include "base/types.h"

namespace palpate {

enum class ToolKind { Sphere, FlatCylinder, Capsule };

/// A rigid tool. Its local frame: the axis is +z, pointing from the tip into the
/// handle; the origin is the tip (the lowest point), so a pose's position is
/// where the tip is and the tool advances along -z.
struct ToolShape {
  ToolKind kind = ToolKind::Sphere;
  double radius = 0.01;       // m
  double length = 0.06;       // m, tip to end; a sphere ignores it
  double edge_radius = 0.0;   // m, rounding of a flat cylinder's rim (0: a tenth of the radius)
};

}  // namespace palpate
