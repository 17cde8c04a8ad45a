#include "app/render/noise_texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace palpate::app {
namespace {

constexpr int edge_texels = 32;                              // texels along an edge
constexpr int octaves = 2;                                   // of 4 and 8 lattice cells along an edge
constexpr float value_scale = 1.2F, gradient_scale = 0.16F;  // bring most of the range into -0.5..0.5

/// A lattice point's gradient, from a hash of its index (wrapped, hence periodic).
Vec3f latticeGradient(int x, int y, int z, int period) {
  const auto wrap = [period](int i) { return static_cast<std::uint32_t>((i % period + period) % period); };
  std::uint32_t h = wrap(x) * 73856093U ^ wrap(y) * 19349663U ^ wrap(z) * 83492791U ^ 0x9E3779B9U;
  Vec3f g;
  for (int k = 0; k < 3; ++k) {
    h ^= h >> 16;
    h *= 0x7FEB352DU;
    h ^= h >> 15;
    h *= 0x846CA68BU;
    g[k] = static_cast<float>(h >> 8) / 8388608.0F - 1.0F;
  }
  return g;
}

/// Perlin's gradient noise with quintic weights.
float gradientNoise(const Vec3f& p, int period) {
  const Vec3f cell = p.array().floor(), f = p - cell;
  const Vec3f w = f.array().cube() * (f.array() * (f.array() * 6 - 15) + 10);
  float sum = 0;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3i corner(c & 1, (c >> 1) & 1, c >> 2);
    const Eigen::Vector3i i = cell.cast<int>() + corner;
    float weight = 1;
    for (int k = 0; k < 3; ++k) weight *= corner[k] ? w[k] : 1 - w[k];
    sum += weight * latticeGradient(i.x(), i.y(), i.z(), period).dot(f - corner.cast<float>());
  }
  return sum;
}

float value(const Vec3f& texel) {
  float sum = 0, amplitude = 1;
  for (int octave = 0, period = 4; octave < octaves; ++octave, period *= 2, amplitude *= 0.5F)
    sum += amplitude * gradientNoise(texel * static_cast<float>(period) / edge_texels, period);
  return sum;
}

std::uint8_t encoded(float centred) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(0.5F + centred, 0.0F, 1.0F)));
}

}  // namespace

NoiseTexture::NoiseTexture() {
  std::vector<float> values(edge_texels * edge_texels * edge_texels);
  const auto at = [&](int x, int y, int z) -> float& {
    return values[((z & (edge_texels - 1)) * edge_texels + (y & (edge_texels - 1))) * edge_texels +
                  (x & (edge_texels - 1))];
  };
  for (int z = 0; z < edge_texels; ++z)
    for (int y = 0; y < edge_texels; ++y)
      for (int x = 0; x < edge_texels; ++x) at(x, y, z) = value(Vec3f(x, y, z));
  std::vector<std::array<std::uint8_t, 4>> texels;
  texels.reserve(values.size());
  for (int z = 0; z < edge_texels; ++z)
    for (int y = 0; y < edge_texels; ++y)
      for (int x = 0; x < edge_texels; ++x) {
        const Vec3f gradient(at(x + 1, y, z) - at(x - 1, y, z), at(x, y + 1, z) - at(x, y - 1, z),
                             at(x, y, z + 1) - at(x, y, z - 1));
        const Vec3f g = gradient_scale * 0.5F * edge_texels / 4 * gradient;
        texels.push_back({encoded(g.x()), encoded(g.y()), encoded(g.z()), encoded(value_scale * 0.5F * at(x, y, z))});
      }
  glBindTexture(GL_TEXTURE_3D, texture_);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA8, edge_texels, edge_texels, edge_texels, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               texels.data());
  glGenerateMipmap(GL_TEXTURE_3D);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glBindTexture(GL_TEXTURE_3D, 0);
}

}  // namespace palpate::app
