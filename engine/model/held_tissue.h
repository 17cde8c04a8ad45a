#pragma once

#include <array>
#include <vector>

#include "base/types.h"
#include "mechanics/boundary_shifts.h"
#include "model/body.h"

namespace palpate {

/// What holds the organ is rigid: a bone, a table. Held is the skin whose nearest node has no free component, imposed
/// by boundaries that the scene does not move, and such nodes inside.
struct HeldTissue {
  static constexpr double clearance = 0.25;  // of the nodes' distance there, that a tool keeps

  struct Point {
    Vec3 position = Vec3::Zero();             // m
    Vec3 outward = Vec3::Zero();              // unit normal of the skin; 0: inside
    double clearance = 0;                     // m
    std::array<int, 3> boundary{-1, -1, -1};  // that hold its components

    /// Where it is when boundaries were moved live.
    Vec3 at(const BoundaryShifts& shifts) const {
      Vec3 x = position;
      for (int c = 0; c < 3; ++c) x[c] += shifts.at(static_cast<std::size_t>(boundary[static_cast<std::size_t>(c)]))[c];
      return x;
    }
  };
  std::vector<Point> points;
  Box3 box;  // of them, grown by the largest clearance
  double least_clearance = 0;

  bool empty() const { return points.empty(); }
};

/// @pre  the rows of nodes and skin, and the skin's normals (SkinBodies), are there
HeldTissue heldTissue(const Body& body);

}  // namespace palpate
