#pragma once

#include "contact/tool.h"
#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// How far the tool at `start` travels along its axis (towards its own -z) before its leading
/// surface first touches the resting surface, vertices, edges and faces alike, m. Negative: it
/// starts that far inside. Infinity: it never touches.
/// For set-up. Test: contact/first_contact_travel_test.cpp.
double firstContactTravel(const TriangleSurface& surface, const ToolShape& tool, const Pose& start);

}  // namespace palpate
