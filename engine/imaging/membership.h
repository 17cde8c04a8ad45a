#pragma once

#include <array>
#include <optional>
#include <string>

#include "imaging/image.h"

namespace palpate {

/// How much of each voxel belongs to a tissue, and where that is known.
struct Membership {
  Image share;               // 0 .. 1
  std::optional<Mask> mask;  // voxels outside say nothing; of the same grid. None: all say something
};

/// Mean share in a tetrahedron with these corners (m): of points on a lattice in it about a voxel apart, each between
/// its voxels, those outside the mask left out. Where all are, the share of the nearest voxel.
/// Test: imaging/membership_test.cpp
double meanShare(const Membership& membership, const std::array<Vec3, 4>& corners);

/// The share at a place (m), between voxels; where the image or its mask says nothing: none.
std::optional<double> shareAt(const Membership& membership, const Vec3& x);

/// Bytes that tell a membership from others: size, place and all values.
std::string identityOf(const Membership& membership);

}  // namespace palpate
