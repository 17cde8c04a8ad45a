#include "imaging/membership.h"

#include <catch2/catch.hpp>

using namespace palpate;

namespace {

/// Share x in a row of voxels of 1 mm.
Membership ramp() {
  Membership m;
  m.share = Image(ImageGrid({21, 21, 21}, Mat3::Identity() * 1e-3, Vec3::Zero()));
  for (int k = 0; k < 21; ++k)
    for (int j = 0; j < 21; ++j)
      for (int i = 0; i < 21; ++i) m.share(i, j, k) = static_cast<float>(i) / 20;
  return m;
}

const std::array<Vec3, 4> cell{Vec3(2e-3, 2e-3, 2e-3), Vec3(14e-3, 3e-3, 2e-3), Vec3(4e-3, 15e-3, 3e-3),
                               Vec3(5e-3, 4e-3, 16e-3)};

}  // namespace

TEST_CASE("The mean of a linear share over a cell is that at its middle", "[imaging][membership]") {
  const double middle = (cell[0] + cell[1] + cell[2] + cell[3]).x() / 4 / 20e-3;
  CHECK(meanShare(ramp(), cell) == Approx(middle).epsilon(1e-4));  // the lattice is symmetric in the corners
}

TEST_CASE("Voxels outside the mask are left out", "[imaging][membership]") {
  Membership m = ramp();
  m.mask = Mask(m.share.grid);
  for (int k = 0; k < 21; ++k)
    for (int j = 0; j < 21; ++j)
      for (int i = 0; i < 21; ++i) {
        (*m.mask)(i, j, k) = i < 6;
        if (i >= 6) m.share(i, j, k) = 1e3F;
      }
  for (int k = 0; k < 21; ++k)
    for (int j = 0; j < 21; ++j) m.share(6, j, k) = 0.3F;  // between the last voxel inside and the first outside
  const double mean = meanShare(m, cell);
  CHECK(mean > 0.1);
  CHECK(mean < 0.3);
}

TEST_CASE("A cell outside an image has the share of the nearest voxel", "[imaging][membership]") {
  std::array<Vec3, 4> far = cell;
  for (Vec3& x : far) x.x() += 1;
  CHECK(meanShare(ramp(), far) == 1);
}

TEST_CASE("Another value, place or mask is another membership", "[imaging][membership]") {
  const std::string before = identityOf(ramp());
  CHECK(identityOf(ramp()) == before);
  Membership m = ramp();
  m.share.value[77] += 0.01F;
  CHECK(identityOf(m) != before);
  m = ramp();
  m.share.grid.origin.x() += 1e-3;
  CHECK(identityOf(m) != before);
  m = ramp();
  m.mask = Mask(m.share.grid);
  CHECK(identityOf(m) != before);
}
