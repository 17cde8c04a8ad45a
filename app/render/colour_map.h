#pragma once

#include "base/types.h"

namespace palpate::app {

/// What the skin's colour means.
enum class ColourMap { Tissue, Displacement, VonMises, J };

/// The values that the colours stand for, for a legend.
struct ColourScale {
  ColourMap map = ColourMap::Tissue;
  double min = 0, max = 1;  // m, Pa or 1
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

/// Colour of the relative value t, 0..1 (clamped), sRGB-encoded 0..1. Displacement and
/// von Mises stress: dark violet to pale yellow with evenly rising lightness; J: blue
/// (compressed) over near-white (t = 0.5) to red (expanded). Tissue has no scale: grey.
Vec3f colourOf(ColourMap map, double t);

}  // namespace palpate::app
