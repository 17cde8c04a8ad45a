#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace palpate {

constexpr double mm = 1e-3;  // m

/// Where the voxels of an image are: the centre of voxel (i, j, k) lies at origin + axes (i, j, k).
///
/// World coordinates are the scan's, RAS, as NIfTI has them: +x to the patient's right, +y to the front (anterior), +z
/// up (superior). One millimetre of the file is 1e-3 here, and nothing is recentred, so that results lie where the scan
/// does.
struct ImageGrid {
  std::array<int, 3> size{0, 0, 0};
  Mat3 axes = Mat3::Identity();     // m; column a: from a voxel's centre to the next along index a. Any angles
  Vec3 origin = Vec3::Zero();       // m, centre of voxel (0, 0, 0)
  Mat3 inverse = Mat3::Identity();  // 1/m, of axes

  ImageGrid() = default;
  ImageGrid(const std::array<int, 3>& voxels, const Mat3& steps, const Vec3& first)
      : size(voxels), axes(steps), origin(first), inverse(steps.inverse()) {}

  std::size_t voxelCount() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  std::size_t at(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(j) + static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(k));
  }
  /// The index of an outermost voxel. @param k  0 to 7
  Vec3 corner(int k) const {
    return Vec3((k & 1) * (size[0] - 1), (k >> 1 & 1) * (size[1] - 1), (k >> 2 & 1) * (size[2] - 1));
  }
  Vec3 worldOf(const Vec3& index) const { return origin + axes * index; }
  Vec3 worldOf(int i, int j, int k) const { return worldOf(Vec3(i, j, k)); }
  /// The index at which a place lies; whole numbers are voxels' centres.
  Vec3 indexOf(const Vec3& X) const { return inverse * (X - origin); }
  /// Whether an index is in a voxel.
  bool holds(const Vec3& index) const {
    return (index.array() >= -0.5).all() && (index.array() < Vec3(size[0], size[1], size[2]).array() - 0.5).all();
  }
  /// m, the distances between neighbouring voxels' centres.
  Vec3 spacing() const { return axes.colwise().norm(); }
  double voxelVolume() const { return std::abs(axes.determinant()); }  // m^3
};

/// Whether two grids have the same voxels, but for rounding (a thousandth of a voxel at the corners).
bool sameGrid(const ImageGrid& a, const ImageGrid& b);

/// Calls each(i, j, k) for all voxels, in their order in memory.
template <class Each>
void forVoxels(const ImageGrid& grid, Each each) {
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) each(i, j, k);
}

/// A value for each voxel; the first index runs fastest.
template <class T>
struct ImageOf {
  ImageGrid grid;
  std::vector<T> value;  // (voxel_count)

  ImageOf() = default;
  explicit ImageOf(const ImageGrid& where, T fill = T{}) : grid(where), value(where.voxelCount(), fill) {}

  T& operator()(int i, int j, int k) { return value[grid.at(i, j, k)]; }
  const T& operator()(int i, int j, int k) const { return value[grid.at(i, j, k)]; }
};
using Image = ImageOf<float>;
using Mask = ImageOf<std::uint8_t>;  // 1 inside, 0 outside
using VectorImage = ImageOf<Vec3f>;

/// Weights of samples at -1, 0, 1 and 2 for the value at t in 0 .. 1 by cubic convolution (Catmull-Rom).
inline std::array<double, 4> cubicWeights(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {-0.5 * t + t2 - 0.5 * t3, 1 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3};
}

/// Value at an index between voxels; beyond the outermost centres that of the nearest voxel.
float nearestValue(const Image& image, const Vec3& index);
float linearValue(const Image& image, const Vec3& index);
/// By cubic convolution (Catmull-Rom: exact for quadratics), clamped to the values of the eight voxels around.
float cubicValue(const Image& image, const Vec3& index);

/// Beyond it whole numbers next to one another are the same as voxels keep them.
inline constexpr int largest_label = 1 << 24;

/// Voxels at which the image is above a half, or is one of `labels` where there are some.
Mask maskOf(const Image& image, const std::vector<int>& labels = {});

std::size_t countOf(const Mask& mask);

}  // namespace palpate
