#pragma once

#include <cmath>

#include "base/types.h"

namespace palpate {

/// The turn by this rotation vector, rad.
inline Quat turnedBy(const Vec3& turn) {
  const double angle = turn.norm();
  return angle > 0 ? Quat(Eigen::AngleAxisd(angle, turn / angle)) : Quat::Identity();
}

/// The rotation vector of the shortest turn that leads from one orientation to the other, rad: to = turnedBy(.) from.
inline Vec3 turnBetween(const Quat& from, const Quat& to) {
  const Quat turn = to * from.conjugate();
  const double sine = turn.vec().norm(), sign = turn.w() < 0 ? -1 : 1;
  // 2 asin(s) / s is 2 where s is small.
  return sign * (sine < 1e-9 ? 2.0 : 2 * std::atan2(sine, std::abs(turn.w())) / sine) * turn.vec();
}

}  // namespace palpate
