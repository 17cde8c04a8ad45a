#pragma once

#include <array>

#include "base/types.h"

namespace palpate {

/// How far boundaries are moved beside their own motions, m; those beyond the first sixteen never are.
struct BoundaryShifts {
  static constexpr int max_count = 16;
  std::array<Vec3, max_count> of;

  BoundaryShifts() { of.fill(Vec3::Zero()); }
  bool operator==(const BoundaryShifts& other) const = default;
  Vec3 at(std::size_t boundary) const { return boundary < max_count ? of[boundary] : Vec3(Vec3::Zero()); }
  bool any() const {
    for (const Vec3& shift : of)
      if (!shift.isZero(0)) return true;
    return false;
  }
};

}  // namespace palpate
