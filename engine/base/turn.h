#pragma once

#include <cmath>

#include "base/types.h"

namespace palpate {

/// The turn by this rotation vector, rad.
inline Quat turnedBy(const Vec3& turn) {
  const double angle = turn.norm();
  return angle > 0 ? Quat(Eigen::AngleAxisd(angle, turn / angle)) : Quat::Identity();
}

/// The shortest turn that brings the z axis to a direction of any length; straight down it is half a turn about x. (Quat's
/// own for any two directions decides that by a decomposition: a tenth of what the compiler does in a file that has it.)
inline Quat uprightOn(const Vec3& direction) {
  const Vec3 up = direction.normalized();
  if (up.z() < -1 + 1e-12) return {0, 1, 0, 0};
  const double scale = std::sqrt(2 * (1 + up.z()));
  return {scale / 2, -up.y() / scale, up.x() / scale, 0};
}

/// The rotation vector of the shortest turn that leads from one orientation to the other, rad: to = turnedBy(.) from.
inline Vec3 turnBetween(const Quat& from, const Quat& to) {
  const Quat turn = to * from.conjugate();
  const double sine = turn.vec().norm(), sign = turn.w() < 0 ? -1 : 1;
  // 2 asin(s) / s is 2 where s is small.
  return sign * (sine < 1e-9 ? 2.0 : 2 * std::atan2(sine, std::abs(turn.w())) / sine) * turn.vec();
}

}  // namespace palpate
