#include "imaging/image.h"

#include <algorithm>

namespace palpate {
namespace {

/// The voxel at or below an index, and how far beyond it that is; inside the grid.
struct Cell {
  int low, high;
  double t;
};

Cell cellAt(double index, int size) {
  const double inside = std::clamp(index, 0.0, static_cast<double>(size - 1));
  const int low = std::min(static_cast<int>(inside), std::max(0, size - 2));
  return {low, std::min(low + 1, size - 1), inside - low};
}

}  // namespace

bool sameGrid(const ImageGrid& a, const ImageGrid& b) {
  if (a.size != b.size) return false;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 index = a.corner(corner);
    if (!(b.inverse * (a.worldOf(index) - b.worldOf(index))).isZero(1e-3)) return false;
  }
  return true;
}

float nearestValue(const Image& image, const Vec3& index) {
  int at[3];
  for (int a = 0; a < 3; ++a)
    at[a] = static_cast<int>(std::lround(std::clamp(index[a], 0.0, static_cast<double>(image.grid.size[a] - 1))));
  return image(at[0], at[1], at[2]);
}

float linearValue(const Image& image, const Vec3& index) {
  const Cell x = cellAt(index[0], image.grid.size[0]), y = cellAt(index[1], image.grid.size[1]),
             z = cellAt(index[2], image.grid.size[2]);
  const auto row = [&](int j, int k) {
    return (1 - x.t) * static_cast<double>(image(x.low, j, k)) + x.t * static_cast<double>(image(x.high, j, k));
  };
  const double low = (1 - y.t) * row(y.low, z.low) + y.t * row(y.high, z.low);
  const double high = (1 - y.t) * row(y.low, z.high) + y.t * row(y.high, z.high);
  return static_cast<float>((1 - z.t) * low + z.t * high);
}

float cubicValue(const Image& image, const Vec3& index) {
  std::size_t at[3][4];
  std::array<double, 4> weight[3];
  const std::size_t stride[3] = {
      1, static_cast<std::size_t>(image.grid.size[0]),
      static_cast<std::size_t>(image.grid.size[0]) * static_cast<std::size_t>(image.grid.size[1])};
  for (int a = 0; a < 3; ++a) {
    const Cell c = cellAt(index[a], image.grid.size[a]);
    weight[a] = cubicWeights(c.t);
    for (int s = 0; s < 4; ++s)
      at[a][s] = stride[a] * static_cast<std::size_t>(std::clamp(c.low + s - 1, 0, image.grid.size[a] - 1));
  }
  const float* value = image.value.data();
  const auto row = [&](int r, int s) {
    const float* first = value + at[1][r] + at[2][s];
    return Eigen::Vector4d(static_cast<double>(first[at[0][0]]), static_cast<double>(first[at[0][1]]),
                           static_cast<double>(first[at[0][2]]), static_cast<double>(first[at[0][3]]));
  };
  Eigen::Vector4d sum = Eigen::Vector4d::Zero(), least = row(1, 1), largest = least;
  for (int s = 0; s < 4; ++s)
    for (int r = 0; r < 4; ++r) {
      const Eigen::Vector4d here = row(r, s);
      sum += weight[1][r] * weight[2][s] * here;
      if ((r == 1 || r == 2) && (s == 1 || s == 2)) {
        least = least.cwiseMin(here);
        largest = largest.cwiseMax(here);
      }
    }
  const double mixed = weight[0][0] * sum[0] + weight[0][1] * sum[1] + weight[0][2] * sum[2] + weight[0][3] * sum[3];
  return static_cast<float>(std::clamp(mixed, std::min(least[1], least[2]), std::max(largest[1], largest[2])));
}

Mask maskOf(const Image& image, const std::vector<int>& labels) {
  Mask mask(image.grid);
  for (std::size_t v = 0; v < image.value.size(); ++v)
    mask.value[v] = labels.empty() ? image.value[v] > 0.5F : std::any_of(labels.begin(), labels.end(), [&](int label) {
      return image.value[v] == static_cast<float>(label);
    });
  return mask;
}

std::size_t countOf(const Mask& mask) {
  return static_cast<std::size_t>(std::count(mask.value.begin(), mask.value.end(), std::uint8_t{1}));
}

}  // namespace palpate
