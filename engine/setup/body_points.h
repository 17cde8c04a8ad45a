#pragma once

#include <vector>

#include "approximation/shape_functions.h"
#include "model/body.h"

namespace palpate {

/// Of each point (m, at rest) the integration point nearest to it.
std::vector<int> nearestPoints(const Body& model, const std::vector<Vec3>& points);

/// Shape functions at points of the body (m, at rest). Where supports end at borders between materials, those of a
/// point do as those of the integration point nearest to it.
/// @param failed  receives the points that the nodes near them can't carry
ShapeTable shapeAt(const Body& model, const std::vector<Vec3>& points, std::vector<InadmissibleSupport>& failed);

}  // namespace palpate
