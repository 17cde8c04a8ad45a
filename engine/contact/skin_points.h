#pragma once

#include <functional>
#include <vector>

#include "contact/skin.h"

namespace palpate {

/// Vertices of the skin that touch for those around them.
struct SkinPoints {
  std::vector<int> vertex;  // (point_count) ascending
  std::vector<float> area;  // (point_count) m^2 of the skin that each stands for: to which it is the nearest
};

/// Of each body those vertices of which none is nearer to an earlier one than `apart` says there.
/// @param of_body  (vertex_count)  @param apart  m, at a place
SkinPoints skinPoints(const SkinModel& skin, const std::vector<int>& of_body,
                      const std::function<double(const Vec3&)>& apart);

}  // namespace palpate
