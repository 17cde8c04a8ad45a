#pragma once

#include <vector>

#include "model/body.h"

namespace palpate::app {

/// A plane through a body at rest; what lies on the side of its normal is taken away.
struct CutPlane {
  Vec3 point = Vec3::Zero();     // m, reference configuration
  Vec3 normal = -Vec3::UnitY();  // need not be a unit vector
};

/// What is left of a body.
struct CutBody : Body {
  std::vector<int> whole_vertex;  // (skin vertex_count) of the whole body's skin, -1: made by the cut
};

/// A body to look at, cut open: its skin is cut along the plane and closed there by a section
/// whose vertices have shape functions of their own, so that it deforms with the body and shows
/// what fields are inside. Along the cut, skin and section have vertices of their own at equal
/// places. Nodes, points and materials are the whole body's; masses, cells and
/// boundaries are left out.
/// Throws std::invalid_argument where the plane leaves nothing.
CutBody cutBody(const Body& model, const CutPlane& plane);

}  // namespace palpate::app
