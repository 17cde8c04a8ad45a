#pragma once

#include "base/types.h"

namespace palpate::app {

/// What the skin's colour means.
enum class ColourMap { Tissue, Displacement, VonMises, J, Pressure };

/// The values that the colours stand for, for a legend.
struct ColourScale {
  ColourMap map = ColourMap::Tissue;
  double min = 0, max = 1;            // m, Pa or 1
  bool below = false, above = false;  // values lie outside, and are striped (belowColour, aboveColour)
};

/// "Displacement", "Von Mises stress", ...
const char* quantityName(ColourMap map);

/// A unit for a scale's numbers, and how many of it an SI unit is.
struct ColourUnit {
  const char* name;
  double per_si;
};

/// The unit in which numbers up to `largest` (m, Pa or 1) read well.
ColourUnit unitOf(ColourMap map, double largest);

/// Colour of the relative value t, 0..1 (clamped), sRGB-encoded 0..1. Displacement, von Mises stress
/// and peak pressure: dark violet to pale yellow with evenly rising lightness; J: blue
/// (compressed) over near-white (t = 0.5) to red (expanded). Tissue has no scale: grey.
Vec3f colourOf(ColourMap map, double t);

/// The stripes over what lies outside a range that was set, sRGB-encoded 0..1: far from all of colourOf's, and stripes
/// need no colour vision.
Vec3f belowColour();
Vec3f aboveColour();

}  // namespace palpate::app
