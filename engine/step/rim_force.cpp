#include "step/rim_force.h"

namespace palpate {

bool isBesideRim(const ToolProfile& tool, const Vec3& local, double area) {
  constexpr double edge_per_root = 1.07;  // of a point's area, on a net of even triangles
  const double edge = edge_per_root * std::sqrt(area);
  if (tool.rounding >= edge) return false;
  const double r = std::hypot(local.x(), local.y());
  for (std::size_t k = 1; k + 1 < static_cast<std::size_t>(tool.corner_count); ++k) {
    const MeridianPoint &before = tool.side_normal[k - 1], &after = tool.side_normal[k], &rim = tool.corner[k];
    if (rim.r > 0 && before.r * after.r + before.z * after.z < turned_away &&
        std::hypot(r - rim.r, local.z() - rim.z) < edge + tool.rounding)
      return true;
  }
  return false;
}

}  // namespace palpate
