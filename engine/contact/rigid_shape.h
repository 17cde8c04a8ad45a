#pragma once

#include <array>
#include <vector>

#include "base/types.h"

namespace palpate {

/// How far places near a closed surface are from it, on a regular grid.
struct GapGrid {
  Vec3 origin = Vec3::Zero();  // m, of the grid's first node
  double cell = 1;             // m
  std::array<int, 3> count{};  // nodes along x, y, z
  std::vector<float> gap;      // (node_count) m, positive on the organ's side; `away` where the surface is open
};

/// What a rigid body keeps the skin from: a solid, or one side of a surface.
struct RigidShape {
  enum class Kind { HalfSpace, Box, Sphere, Cylinder, Surface };
  Kind kind = Kind::Surface;
  Vec3 point = Vec3::Zero();    // m; HalfSpace: of its plane; Box, Sphere: its centre; Cylinder: the middle of its base
  Vec3 normal = Vec3::UnitZ();  // unit; HalfSpace: out of it; Cylinder: its axis, from the base up
  Vec3 half = Vec3::Zero();     // m; Box: half of its edges
  double radius = 0;            // m; Sphere, Cylinder; Surface: of a ball as round (meanRadius)
  double height = 0;            // m; Cylinder
  GapGrid grid;                 // Surface

  static constexpr double away = 1e3;           // m, further than any gap that matters
  static constexpr double farthest_out = 3e-3;  // m beyond a surface, from which on a point is left alone

  /// The gap between x and the shape, m, in its own frame; negative in it. Exact for solids; of a surface trilinear
  /// between the grid's nodes, and `away` beyond the grid, beside openings and too far beyond it.
  /// @param normal  its gradient, not zero, of any length
  /// Real-time.
  double gapAt(const Vec3& x, Vec3& normal) const;

  /// The unit normal at x: of a surface the gap's mean slope over a cell of the grid around x, which turns steadily.
  /// The gradient jumps from cell to cell, and with it a force, so that what lies on it would never come to rest.
  /// @param gradient  of gapAt(x), which it is beside an opening, and of solids
  /// Real-time.
  Vec3 normalAt(const Vec3& x, const Vec3& gradient) const;

  Vec3 middle() const;  // m, or a point on it

  /// A bound from below on the gap at x, m, where there is one to speak of: a place has to move so far, or further, to
  /// touch. Of solids the gap itself, of surfaces the way to their grid. Real-time.
  double leastGap(const Vec3& x) const;
};

}  // namespace palpate
