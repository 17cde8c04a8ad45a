#include "imaging/mask_filter.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace palpate;

TEST_CASE("The largest part stays, and its holes are filled", "[imaging][mask]") {
  Mask mask(ImageGrid({12, 8, 8}, Mat3::Identity() * 1e-3, Vec3::Zero()));
  for (int k = 1; k < 7; ++k)
    for (int j = 1; j < 7; ++j)
      for (int i = 1; i < 7; ++i) mask(i, j, k) = 1;
  mask(3, 3, 3) = 0;   // a hole
  mask(10, 4, 4) = 1;  // a crumb
  MaskParts parts;
  const Mask kept = keepLargestPart(mask, parts);
  CHECK(parts.part_count == 2);
  CHECK(parts.dropped_voxels == 1);
  CHECK(parts.filled_voxels == 1);
  CHECK(countOf(kept) == 216);
  CHECK(countOf(keepLargestPart(Mask(mask.grid), parts)) == 0);
}

TEST_CASE("Parts that meet late, or only across an edge, are told apart", "[imaging][mask]") {
  // A comb whose teeth meet in the last row, and beside it voxels that touch it across edges only.
  Mask mask(ImageGrid({9, 5, 3}, Mat3::Identity() * 1e-3, Vec3::Zero()));
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 7; i += 2) mask(i, j, 1) = 1;
  for (int i = 0; i < 7; ++i) mask(i, 4, 1) = 1;
  mask(7, 4, 2) = 1;  // beside the row's end, across an edge
  mask(1, 0, 2) = 1;  // above a gap between teeth
  MaskParts parts;
  const Mask kept = keepLargestPart(mask, parts);
  CHECK(parts.part_count == 3);
  CHECK(parts.dropped_voxels == 2);
  CHECK(parts.filled_voxels == 0);
  CHECK(countOf(kept) == 4 * 4 + 7);
}

TEST_CASE("A thin tail is left out up to its root, a body and its edges stay", "[imaging][mask]") {
  Mask mask(ImageGrid({40, 16, 16}, Mat3::Identity() * 1e-3, Vec3(0.1, 0, -0.2)));
  for (int k = 2; k < 14; ++k)
    for (int j = 2; j < 14; ++j)
      for (int i = 2; i < 16; ++i) mask(i, j, k) = 1;
  const std::size_t body = countOf(mask);
  CHECK(countOf(withoutTails(mask, 3e-3, 3e-3)) == body);
  for (int i = 16; i < 38; ++i) mask(i, 8, 8) = mask(i, 8, 9) = 1;
  const Mask cut = withoutTails(mask, 3e-3, 3e-3);
  CHECK(countOf(cut) >= body);
  CHECK(countOf(cut) <= body + 8);
  CHECK(cut(37, 8, 8) == 0);
  CHECK(countOf(withoutTails(mask, 0.02, 3e-3)) == 0);  // the ball fits nowhere
}

TEST_CASE("Distances to a mask's border are those by hand, on unequal edges", "[imaging][mask]") {
  Mask mask(ImageGrid({9, 7, 5}, Vec3(1e-3, 2e-3, 3e-3).asDiagonal(), Vec3::Zero()));
  mask(4, 3, 2) = 1;
  const Image d = signedDistance(mask);
  const double half = 0.5 * std::cbrt(6e-9);
  CHECK(d(4, 3, 2) == Approx(half - 1e-3));  // the nearest voxel outside is 1 mm away
  CHECK(d(6, 2, 1) == Approx(std::sqrt(4.0 + 4 + 9) * 1e-3 - half));
  double worst = 0;
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 7; ++j)
      for (int i = 0; i < 9; ++i)
        if (!mask(i, j, k))
          worst = std::max(
              worst, std::abs(d(i, j, k) + half - (mask.grid.worldOf(i, j, k) - mask.grid.worldOf(4, 3, 2)).norm()));
  CHECK(worst < 1e-8);
}

TEST_CASE("Smoothing keeps a constant and a line, and spreads a point by its width in m", "[imaging][mask]") {
  Image line(ImageGrid({40, 3, 3}, Vec3(1e-3, 2e-3, 1e-3).asDiagonal(), Vec3::Zero()));
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 40; ++i) line(i, j, k) = static_cast<float>(i);
  smooth(line, 2e-3);
  CHECK(line(20, 1, 1) == Approx(20).epsilon(1e-4));

  Image point(ImageGrid({41, 41, 1}, Vec3(1e-3, 0.5e-3, 1e-3).asDiagonal(), Vec3::Zero()));
  point(20, 20, 0) = 1;
  smooth(point, 2e-3);
  double sum = 0, x2 = 0, y2 = 0;
  for (int j = 0; j < 41; ++j)
    for (int i = 0; i < 41; ++i) {
      sum += point(i, j, 0);
      x2 += point(i, j, 0) * (i - 20) * (i - 20) * 1e-6;
      y2 += point(i, j, 0) * (j - 20) * (j - 20) * 0.25e-6;
    }
  CHECK(sum == Approx(1).epsilon(1e-3));
  CHECK(std::sqrt(x2 / sum) == Approx(2e-3).epsilon(0.03));  // cut off at three widths
  CHECK(std::sqrt(y2 / sum) == Approx(2e-3).epsilon(0.03));
}

TEST_CASE("A crop has the mask and the margin around it, also beyond the image", "[imaging][mask]") {
  Mask mask(ImageGrid({10, 10, 10}, Mat3::Identity() * 1e-3, Vec3(0.1, 0, 0)));
  mask(0, 5, 9) = 1;
  const Mask crop = croppedTo(mask, 2e-3);
  CHECK(countOf(crop) == 1);
  CHECK(crop.grid.size[0] == 7);
  CHECK(crop(3, 3, 3) == 1);
  CHECK((crop.grid.worldOf(3, 3, 3) - mask.grid.worldOf(0, 5, 9)).norm() < 1e-12);
}
