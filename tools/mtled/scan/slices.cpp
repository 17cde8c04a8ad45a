#include "mtled/scan/slices.h"

#include <algorithm>
#include <cmath>

namespace palpate::tools {
namespace {

constexpr int tile = 420, gap = 6;  // px

/// A slice: its plane's axes, along the picture's rows and down its columns.
struct Plane {
  Vec3 across, down;
};
const Plane planes[3] = {{-Vec3::UnitX(), -Vec3::UnitY()},   // axial, from below
                         {-Vec3::UnitX(), -Vec3::UnitZ()},   // coronal, from the front
                         {-Vec3::UnitY(), -Vec3::UnitZ()}};  // sagittal, from the left

bool insideOf(const Mask& mask, const Vec3& X) {
  const Vec3 index = mask.grid.indexOf(X);
  int at[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = static_cast<int>(std::lround(index[a]));
    if (at[a] < 0 || at[a] >= mask.grid.size[static_cast<std::size_t>(a)]) return false;
  }
  return mask(at[0], at[1], at[2]) != 0;
}

bool covers(const ImageGrid& grid, const Vec3& index) {
  for (int a = 0; a < 3; ++a)
    if (index[a] < -0.5 || index[a] > grid.size[static_cast<std::size_t>(a)] - 0.5) return false;
  return true;
}

std::uint8_t byteOf(double value) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0))); }

void drawTile(const SliceColumn& column, const Plane& plane, const Vec3& middle, double pixel, double low, double high,
              int left, int top, Picture& picture) {
  const auto worldOf = [&](int x, int y) {
    return Vec3(middle + pixel * ((x - tile / 2) * plane.across + (y - tile / 2) * plane.down));
  };
  for (int y = 0; y < tile; ++y)
    for (int x = 0; x < tile; ++x) {
      const Vec3 X = worldOf(x, y), index = column.image->grid.indexOf(X);
      double grey = 0;
      if (covers(column.image->grid, index)) grey = (linearValue(*column.image, index) - low) / (high - low);
      Vec3 colour = Vec3::Constant(std::clamp(grey, 0.0, 1.0));
      if (column.tint) {
        const double share = linearValue(*column.tint, column.tint->grid.indexOf(X));
        colour += 0.6 * std::clamp(share, 0.0, 1.0) * (Vec3(0.15, 0.55, 1.0) - colour);
      }
      if (column.contour && insideOf(*column.contour, X) &&
          !(insideOf(*column.contour, worldOf(x + 1, y)) && insideOf(*column.contour, worldOf(x - 1, y)) &&
            insideOf(*column.contour, worldOf(x, y + 1)) && insideOf(*column.contour, worldOf(x, y - 1))))
        colour = Vec3(1.0, 0.55, 0.1);
      for (int c = 0; c < 3; ++c)
        picture.rgb[(static_cast<std::size_t>(top + y) * static_cast<std::size_t>(picture.width) +
                     static_cast<std::size_t>(left + x)) *
                        3 +
                    static_cast<std::size_t>(c)] = byteOf(colour[c]);
    }
}

}  // namespace

Picture drawSlices(const std::vector<SliceColumn>& columns, const Box3& box, const Vec3& place, double low,
                   double high) {
  Picture picture;
  const auto count = static_cast<int>(columns.size());
  picture.width = count * tile + (count - 1) * gap;
  picture.height = 3 * tile + 2 * gap;
  picture.rgb.assign(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3, 255);
  const double pixel = box.sizes().maxCoeff() / tile;
  for (int c = 0; c < count; ++c)
    for (int p = 0; p < 3; ++p) {
      // In the middle of the box but for the slice's own axis, along which it is at the place.
      const Vec3 normal = planes[p].across.cross(planes[p].down).cwiseAbs();
      const Vec3 middle = box.center() + normal.cwiseProduct(place - box.center());
      drawTile(columns[static_cast<std::size_t>(c)], planes[p], middle, pixel, low, high, c * (tile + gap),
               p * (tile + gap), picture);
    }
  return picture;
}

std::pair<double, double> windowOf(const Image& image, const Mask& mask) {
  std::vector<float> values;
  for (std::size_t v = 0; v < image.value.size(); ++v)
    if (mask.value[v]) values.push_back(image.value[v]);
  if (values.empty()) return {0, 1};
  const auto at = [&](double share) {
    auto middle = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), middle, values.end());
    return static_cast<double>(*middle);
  };
  const double low = std::min(at(0.01), 0.1 * at(0.995)), high = at(0.995);
  return {low, std::max(high, low + 1e-6)};
}

Box3 boxOf(const Mask& mask, double margin) {
  Box3 box;
  for (int k = 0; k < mask.grid.size[2]; ++k)
    for (int j = 0; j < mask.grid.size[1]; ++j)
      for (int i = 0; i < mask.grid.size[0]; ++i)
        if (mask(i, j, k)) box.extend(mask.grid.worldOf(i, j, k));
  box.min().array() -= margin;
  box.max().array() += margin;
  return box;
}

}  // namespace palpate::tools
