#pragma once

#include <array>
#include <string>

#include "scene/scene.h"

namespace palpate::tools {

/// A boundary on the plane normal . (x - point) = 0, m.
inline BoundarySpec planeBoundary(const std::string& name, const Vec3& point, const Vec3& normal,
                                  const std::array<bool, 3>& components = {true, true, true}) {
  BoundarySpec b;
  b.name = name;
  b.region.kind = Region::Kind::NearPlane;
  b.region.point = point;
  b.region.normal = normal;
  b.region.distance = 1e-9;
  for (std::size_t c = 0; c < 3; ++c) b.component[c] = components[c];
  return b;
}

/// A boundary's motion, or a load, is in proportion to the time, 0 .. 1 s.
template <class Load>
void beEven(Load& load) {
  load.duration = 1;
  load.curve.kind = LoadCurve::Kind::Linear;
}

}  // namespace palpate::tools
