#pragma once

#include "base/types.h"

namespace palpate {

enum class ToolKind { Sphere, FlatCylinder, Capsule };

/// A rigid tool. Its local frame: the axis is +z, pointing from the tip into the
/// handle; the origin is the tip (the lowest point), so a pose's position is
/// where the tip is and the tool advances along -z.
struct ToolShape {
  ToolKind kind = ToolKind::Sphere;
  double radius = 0.01;      // m
  double length = 0.06;      // m, tip to end; a sphere ignores it, a capsule is at least 2 radius long
  double edge_radius = 0.0;  // m, rounding of a flat cylinder's rims (0: 0.3 radius, see edgeRadius)
};

/// Signed distance of a point to a tool's surface, m (negative inside), and its gradient there.
struct ToolDistance {
  double distance = 0;
  Vec3 normal = -Vec3::UnitZ();  // unit, outward
};

/// Exact signed distance to the tool.
///
///   sphere         |x - c| - R,  c = (0, 0, R)
///   capsule        distance to the segment between the cap centres, less R
///   flat cylinder  distance to the cylinder of radius R - e and ends drawn in by e, less e
///
/// The distance is C1 outside and inside down to the depth smoothDepth(); deeper the normal jumps
/// where the nearest side changes (the medial axis).
/// @param local  point in the tool's frame, m
/// Real-time. Test: contact/tool_test.cpp (closed forms, finite differences, Lipschitz bound).
ToolDistance toolDistance(const ToolShape& tool, const Vec3& local);

/// The rounding in use, m: edge_radius or its default, no more than fits the cylinder.
///
/// A rim sharper than the skin's spacing e can't be felt smoothly: dragged half a radius deep at
/// 10 mm/s, vertices snap around it one by one and a 2 ms tick changes the force by 5-25 % of the peak
/// at edge_radius = 0.3 e, 2-6 % at e, below 1.2 % from 1.2 e on. Hence the default of 0.3 R for skins with
/// edges of 0.25 R. Draw the tool with this value, too.
double edgeRadius(const ToolShape& tool);

/// Depth below the surface within which the nearest side of the tool is unambiguous, m.
double smoothDepth(const ToolShape& tool);

/// How far a point inside the tool must go along the unit `direction` to leave it, m; 0 outside.
/// Real-time: bounded work (at most 32 distance evaluations; relative error < 1e-3 but at grazing exits).
double exitDistance(const ToolShape& tool, const Vec3& local, const Vec3& direction);

/// Height of the tool's leading surface above the tip at distance `r` from the axis, m; infinity for r > R.
double tipProfile(const ToolShape& tool, double r);

/// Bound on how far any point of the tool travels between two poses, m. Real-time.
double largestTravel(const ToolShape& tool, const Pose& from, const Pose& to);

}  // namespace palpate
