#pragma once

#include <vector>

#include "discretization/surface/surface_tree.h"

namespace palpate {

/// Points of an organ's surface and where they go, m.
struct MovedPoints {
  std::vector<Vec3> X, u;  // (point_count)
};

/// The skin between measured points, as a sheet that bends least (thin-plate spline, Duchon 1977): points of the
/// surface about `apart` from each other and no nearer than 3/4 of that to a measured one, with the displacement
///   u(X) = a + B X + sum_k w_k r_k^2 log r_k,   r_k = |X - X_k|,   sum_k w_k = 0,   sum_k w_k X_k = 0
/// that is measured at all X_k. They lie on the side of the organ that the measured points are on, over the convex hull
/// of these in the plane that fits them best, and half their distance (the median to the nearest other) around it.
/// @param measured  on the surface, at least three that are not in line; else nothing is added
/// Test: simulation/sheet_test.cpp
MovedPoints sheetBetween(const MovedPoints& measured, const SurfaceTree& organ, double apart);

}  // namespace palpate
