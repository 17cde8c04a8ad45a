#pragma once

#include <vector>

#include "base/types.h"
#include "model/body.h"

namespace palpate {

/// What holds the organ is rigid: a bone, a table. Held is the skin whose nearest node has no free component, imposed by
/// boundaries that the scene does not move, and such nodes inside.
struct HeldTissue {
  static constexpr double clearance = 0.25;  // of the nodes' distance there, that a tool keeps

  struct Point {
    Vec3 position = Vec3::Zero();  // m
    Vec3 outward = Vec3::Zero();   // unit normal of the skin; 0: inside
    double clearance = 0;          // m
    int boundary = -1;             // that holds it
  };
  std::vector<Point> points;
  Box3 box;  // of them, grown by the largest clearance
  double least_clearance = 0;

  bool empty() const { return points.empty(); }
};

HeldTissue heldTissue(const Body& body);

}  // namespace palpate
