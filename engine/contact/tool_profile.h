#pragma once

#include <array>
#include <initializer_list>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Signed distance of a point to a tool's surface, m (negative inside), and its gradient there.
struct ToolDistance {
  double distance = 0;
  Vec3 normal = -Vec3::UnitZ();  // unit, outward
};

/// A point of the half plane that is turned about the tool's axis: distance from the axis and height above the tip, m.
struct MeridianPoint {
  double r = 0, z = 0;
};

/// What a tool's surface is: a convex core, turned about the axis and grown by a ball of radius `rounding`. The tip
/// is at z = 0. Distance, height and mesh follow from it.
///
/// The core's corners run from the tip's end of the axis to the other, outside on their right. A ball's core is a
/// point of the axis, a capsule's a piece of it.
struct ToolProfile {
  static constexpr int max_corners = 6;

  double radius = 0;    // m, the largest distance from the axis
  double length = 0;    // m, from the tip to the end
  double rounding = 0;  // m; also the depth below which the nearest side of the tool may be ambiguous
  int corner_count = 0;
  std::array<MeridianPoint, max_corners> corner;       // (corner_count)
  std::array<MeridianPoint, max_corners> side_normal;  // (corner_count - 1) unit, outward; of corner k to k + 1
  std::array<double, max_corners> side_length;         // (corner_count - 1) m

  /// The distance where a tool's file has a shorter formula than the general one; a test holds the two together.
  ToolDistance (*closed_form)(const ToolProfile&, const Vec3&) = nullptr;
};

/// A profile with these corners, of which equal neighbours count as one.
ToolProfile makeToolProfile(double radius, double length, double rounding,
                            std::initializer_list<MeridianPoint> corners);

/// Exact signed distance to the tool: that to the core less the rounding.
///
/// The distance is C1 outside and inside down to the depth `rounding`; deeper the normal jumps where the nearest side
/// changes (the medial axis).
/// @param local  point in the tool's frame, m
/// Real-time. Test: contact/tool_test.cpp (closed forms, finite differences, Lipschitz bound).
ToolDistance toolDistance(const ToolProfile& profile, const Vec3& local);

/// The same by the general formula, whether or not the tool has a shorter one.
ToolDistance generalDistance(const ToolProfile& profile, const Vec3& local);

/// How far a point inside the tool must go along the unit `direction` to leave it, m; 0 outside.
/// Real-time: bounded work (at most 32 distance evaluations; relative error < 1e-3 but at grazing exits).
double exitDistance(const ToolProfile& profile, const Vec3& local, const Vec3& direction);

/// Height of the tool's leading surface above the tip at distance `r` from the axis, m; infinity for r > radius.
double tipProfile(const ToolProfile& profile, double r);

/// Points of the surface in the half plane from the tip's end of the axis to the other, outside on their right:
/// fine enough to draw, arcs in pieces of 9 degrees for a ball and of up to 23 where the rounding is small.
std::vector<MeridianPoint> outline(const ToolProfile& profile);

}  // namespace palpate
