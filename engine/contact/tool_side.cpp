#include "contact/tool_side.h"

#include <algorithm>

namespace palpate {
namespace {

/// Depth, per rounding, from which the nearest side is distrusted.
constexpr double kDeep = 0.5;

/// Cosines of the turn between the nearest side and the remembered one: up to the first the nearest is taken, from the
/// second on the remembered.
constexpr double kSameSide = 0.7;
constexpr double kOtherSide = 0.3;

}  // namespace

ToolDistance distanceBySide(const ToolProfile& tool, const Vec3& local, const Vec3& old_local, const Vec3f& last_normal,
                            Vec3f& side) {
  const ToolDistance nearest = toolDistance(tool, local);
  const bool deep = nearest.distance <= -kDeep * tool.rounding;
  if (!deep && (side.isZero() || !(nearest.distance <= 0.0))) {  // the usual case; also where it is not a number
    side.setZero();
    return nearest;
  }
  Vec3 entry = side.cast<double>();
  if (side.isZero()) entry = last_normal.isZero() ? toolDistance(tool, old_local).normal : last_normal.cast<double>();
  const double same = nearest.normal.dot(entry);
  if (!deep && same >= kSameSide) {
    side.setZero();
    return nearest;
  }
  side = entry.cast<float>();
  if (same >= kSameSide) return nearest;
  const double turn = std::min(1.0, (kSameSide - same) / (kSameSide - kOtherSide));
  const Vec3 out = ((1.0 - turn) * nearest.normal + turn * entry).normalized();
  return {-exitDistance(tool, local, out), out};
}

}  // namespace palpate
