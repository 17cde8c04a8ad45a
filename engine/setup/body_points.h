#pragma once

#include <vector>

#include "approximation/shape_functions.h"
#include "model/body.h"

namespace palpate {

/// Of each point (m, at rest) the body (a number below body_count) that has the integration point nearest to it.
std::vector<int> bodiesAt(const Body& model, const std::vector<Vec3>& points);

/// Of each point the integration point nearest to it, of those of its body: another body's may be nearer. Beside a
/// border between materials the one whose cell it lies in: the nearest may be of the other side, where J of a soft
/// layer on one thirty times as stiff is 0.99 for 0.79.
/// @param body  (points.size()) of which of the bodies each is
std::vector<int> nearestPoints(const Body& model, const std::vector<Vec3>& points, const std::vector<int>& body);

/// Shape functions at points of the body (m, at rest). Where supports end at borders between materials, those of a
/// point do as those of the integration point nearest to it; what the nodes near it can't carry follows one
/// (followPoints).
/// @param body  (points.size()) of which of the bodies each is
ShapeTable shapeAt(const Body& model, const std::vector<Vec3>& points, const std::vector<int>& body);

/// The same, of the bodies that the points lie in.
inline ShapeTable shapeAt(const Body& model, const std::vector<Vec3>& points) {
  return shapeAt(model, points, bodiesAt(model, points));
}

}  // namespace palpate
