#include "app/render/colour.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/render/colour_map.h"

using namespace palpate;
using namespace palpate::app;

TEST_CASE("CIELAB of sRGB's primaries is as published", "[colour]") {
  // Lindbloom's colour calculator, sRGB, D65.
  CHECK((labFromSrgb(Vec3f(1, 1, 1)) - Vec3f(100, 0, 0)).norm() < 0.05F);
  CHECK((labFromSrgb(Vec3f(1, 0, 0)) - Vec3f(53.24F, 80.09F, 67.20F)).norm() < 0.05F);
  CHECK((labFromSrgb(Vec3f(0, 0, 1)) - Vec3f(32.30F, 79.19F, -107.86F)).norm() < 0.05F);
  CHECK(labFromSrgb(Vec3f::Zero()).norm() < 1e-4F);
}

TEST_CASE("Lab and sRGB are each other's inverse", "[colour]") {
  for (float r = 0; r <= 1; r += 0.25F)
    for (float g = 0; g <= 1; g += 0.25F)
      for (float b = 0; b <= 1; b += 0.25F)
        CHECK((srgbFromLab(labFromSrgb(Vec3f(r, g, b))) - Vec3f(r, g, b)).norm() < 2e-3F);
}

TEST_CASE("Magnitudes grow evenly lighter", "[colour]") {
  for (int i = 0; i < 20; ++i) {
    const float step = labFromSrgb(colourOf(ColourMap::VonMises, (i + 1) / 20.0)).x() -
                       labFromSrgb(colourOf(ColourMap::VonMises, i / 20.0)).x();
    CHECK(step == Approx(72.0 / 20).margin(0.8));  // L* from 20 to 92
  }
}

TEST_CASE("J's colours are as light on either side of 1, and neutral there", "[colour]") {
  for (double t : {0.0, 0.1, 0.2, 0.3, 0.4})
    CHECK(labFromSrgb(colourOf(ColourMap::J, t)).x() ==
          Approx(labFromSrgb(colourOf(ColourMap::J, 1 - t)).x()).margin(1.5));
  const Vec3f middle = labFromSrgb(colourOf(ColourMap::J, 0.5));
  CHECK(std::hypot(middle.y(), middle.z()) < 4);
  CHECK(colourOf(ColourMap::J, 0.05).z() > colourOf(ColourMap::J, 0.05).x());  // compressed: blue
  CHECK(colourOf(ColourMap::J, 0.95).x() > colourOf(ColourMap::J, 0.95).z());  // expanded: red
}

TEST_CASE("Values beyond the scale take its ends' colours", "[colour]") {
  CHECK(colourOf(ColourMap::Displacement, 7) == colourOf(ColourMap::Displacement, 1));
  CHECK(colourOf(ColourMap::Displacement, -7) == colourOf(ColourMap::Displacement, 0));
}
