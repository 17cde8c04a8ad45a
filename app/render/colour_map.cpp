#include "app/render/colour_map.h"

#include <algorithm>
#include <array>

#include "app/render/colour.h"

namespace palpate::app {
namespace {

using Table = std::array<std::array<float, 3>, 9>;

// CIELAB, evenly spaced in L* from 20 to 92, hue turning once from violet over blue-green to
// yellow; entries chosen inside the sRGB gamut. Linear interpolation in Lab keeps lightness even.
constexpr Table sequential_lab = {{{20, 30, -36},
                                   {29, 24, -37},
                                   {38, 9, -32},
                                   {47, -12, -20},
                                   {56, -28, -6},
                                   {65, -38, 13},
                                   {74, -38, 37},
                                   {83, -27, 60},
                                   {92, -8, 74}}};

// CIELAB, lightness rising and falling symmetrically, so that equal distances from the
// middle look equally strong.
constexpr Table diverging_lab = {{{32, 8, -46},
                                  {47, -2, -42},
                                  {62, -6, -32},
                                  {78, -5, -17},
                                  {92, 0, 2},
                                  {78, 17, 17},
                                  {62, 36, 29},
                                  {47, 50, 36},
                                  {32, 50, 34}}};

Vec3f interpolate(const Table& table, float t) {
  const float s = t * static_cast<float>(table.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(s), table.size() - 2);
  const float w = s - static_cast<float>(i);
  Vec3f c;
  for (int k = 0; k < 3; ++k) c[k] = (1 - w) * table[i][k] + w * table[i + 1][k];
  return c;
}

}  // namespace

const char* quantityName(ColourMap map) {
  switch (map) {
    case ColourMap::Tissue:
      return "Tissue";
    case ColourMap::Displacement:
      return "Displacement";
    case ColourMap::VonMises:
      return "Von Mises stress";
    case ColourMap::J:
      return "Volume ratio J";
    case ColourMap::Pressure:
      return "Peak pressure";
  }
  return "";
}

ColourUnit unitOf(ColourMap map, double largest) {
  switch (map) {
    case ColourMap::Displacement:
      return {"mm", 1e3};
    case ColourMap::VonMises:
    case ColourMap::Pressure:
      return largest >= 2e3 ? ColourUnit{"kPa", 1e-3} : ColourUnit{"Pa", 1};
    case ColourMap::J:
    case ColourMap::Tissue:
      break;
  }
  return {"", 1};
}

Vec3f colourOf(ColourMap map, double t) {
  const float s = static_cast<float>(std::clamp(t, 0.0, 1.0));
  if (map == ColourMap::Tissue) return Vec3f::Constant(0.5F);
  return srgbFromLab(interpolate(map == ColourMap::J ? diverging_lab : sequential_lab, s));
}

Vec3f belowColour() { return {0.10F, 0.10F, 0.10F}; }
Vec3f aboveColour() { return {0.90F, 0.10F, 0.10F}; }

}  // namespace palpate::app
