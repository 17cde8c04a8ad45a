#include "app/render/colour.h"

#include <algorithm>
#include <cmath>

namespace palpate::app {
namespace {

const Vec3f white(0.95047F, 1.0F, 1.08883F);  // D65, XYZ

// CIE 15:2004: the cube root is replaced by a line near black.
constexpr float epsilon = 216.0F / 24389.0F;
constexpr float kappa = 24389.0F / 27.0F;

Eigen::Matrix3f xyzFromRgb() {
  Eigen::Matrix3f m;
  m << 0.4124564F, 0.3575761F, 0.1804375F,  //
      0.2126729F, 0.7151522F, 0.0721750F,   //
      0.0193339F, 0.1191920F, 0.9503041F;
  return m;
}

}  // namespace

float encodeSrgb(float linear) {
  return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
}

float decodeSrgb(float encoded) {
  return encoded <= 0.04045F ? encoded / 12.92F : std::pow((encoded + 0.055F) / 1.055F, 2.4F);
}

Vec3f labFromSrgb(const Vec3f& encoded) {
  static const Eigen::Matrix3f xyz_from_rgb = xyzFromRgb();
  const Vec3f xyz = (xyz_from_rgb * encoded.unaryExpr(&decodeSrgb)).cwiseQuotient(white);
  const Vec3f f = xyz.unaryExpr([](float t) { return t > epsilon ? std::cbrt(t) : (kappa * t + 16) / 116; });
  return {116 * f.y() - 16, 500 * (f.x() - f.y()), 200 * (f.y() - f.z())};
}

Vec3f srgbFromLab(const Vec3f& lab) {
  static const Eigen::Matrix3f rgb_from_xyz = xyzFromRgb().inverse();
  const float fy = (lab.x() + 16) / 116;
  const Vec3f f(fy + lab.y() / 500, fy, fy - lab.z() / 200);
  const Vec3f xyz = f.unaryExpr([](float t) { return t * t * t > epsilon ? t * t * t : (116 * t - 16) / kappa; });
  const Vec3f linear = rgb_from_xyz * xyz.cwiseProduct(white);
  return linear.unaryExpr([](float c) { return encodeSrgb(std::clamp(c, 0.0F, 1.0F)); });
}

}  // namespace palpate::app
