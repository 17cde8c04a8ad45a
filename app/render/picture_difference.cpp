#include "app/render/picture_difference.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "app/render/colour.h"

namespace palpate::app {
namespace {

constexpr double full_scale_delta_E = 20;
constexpr float dim = 0.25F;

std::array<float, 256> decodeTable() {
  std::array<float, 256> table{};
  for (int i = 0; i < 256; ++i) table[i] = decodeSrgb(static_cast<float>(i) / 255);
  return table;
}

/// CIELAB of the picture after the tent blur.  (height * width)
std::vector<Vec3f> blurredLab(const Picture& picture) {
  static const std::array<float, 256> linear = decodeTable();
  constexpr std::array<float, 3> tent{0.25F, 0.5F, 0.25F};
  const int w = picture.width, h = picture.height;
  std::vector<Vec3f> lab(static_cast<std::size_t>(w) * h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int row = std::clamp(y + dy, 0, h - 1), column = std::clamp(x + dx, 0, w - 1);
          const std::uint8_t* p = &picture.rgb[3 * (static_cast<std::size_t>(row) * w + column)];
          sum += tent[dx + 1] * tent[dy + 1] * Vec3f(linear[p[0]], linear[p[1]], linear[p[2]]);
        }
      lab[static_cast<std::size_t>(y) * w + x] = labFromSrgb(sum.unaryExpr([](float c) { return encodeSrgb(c); }));
    }
  return lab;
}

}  // namespace

PictureDifference difference(const Picture& a, const Picture& b) {
  if (a.width != b.width || a.height != b.height)
    throw std::invalid_argument("pictures of " + std::to_string(a.width) + "x" + std::to_string(a.height) + " and " +
                                std::to_string(b.width) + "x" + std::to_string(b.height) + " can't be compared");
  const std::vector<Vec3f> lab_a = blurredLab(a), lab_b = blurredLab(b);
  PictureDifference d;
  d.image = a;
  std::size_t strong = 0;
  for (std::size_t i = 0; i < lab_a.size(); ++i) {
    const double delta_E = (lab_a[i] - lab_b[i]).norm();
    d.mean += delta_E;
    d.worst = std::max(d.worst, delta_E);
    strong += delta_E > PictureDifference::strong_delta_E;
    const float mark = static_cast<float>(std::min(1.0, delta_E / full_scale_delta_E));
    const std::array<float, 3> yellow{255, 220, 40};
    for (int k = 0; k < 3; ++k)
      d.image.rgb[3 * i + k] = static_cast<std::uint8_t>((1 - mark) * dim * a.rgb[3 * i + k] + mark * yellow[k]);
  }
  const double pixels = static_cast<double>(std::max<std::size_t>(1, lab_a.size()));
  d.mean /= pixels;
  d.strong_share = strong / pixels;
  return d;
}

bool looksSame(const PictureDifference& difference, double max_mean, double max_strong_share) {
  return difference.mean <= max_mean && difference.strong_share <= max_strong_share;
}

}  // namespace palpate::app
