#pragma once

#include <functional>
#include <string>

#include "discretization/surface/surface_tree.h"
#include "scene/scene.h"

namespace palpate {

/// The scene with a boundary of its own for each measured point of its [[prescribed]] points (PointLoad), which then
/// knows where on the organ the point is and how far it goes. The point on the organ is the one nearest to where the
/// point was before or, where that was not measured, to where it is. Points nearer to each other than half the spacing
/// become one, in their middle. Where they carry a sheet, the skin between them has points, too (sheet.h). The same
/// scene where it has none.
/// @param warn  told how many were joined
/// Throws InputError where a point is more than 40 mm from the surface: its frame or unit is probably another; and
/// where one lies in what another boundary holds or moves.
/// Test: simulation/point_boundaries_test.cpp
Scene withPointBoundaries(const Scene& scene, const SurfaceTree& organ,
                          const std::function<void(const std::string&)>& warn = {});

}  // namespace palpate
