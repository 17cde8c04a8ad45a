#pragma once

#include "app/render/picture.h"

namespace palpate::app {

/// How differently two pictures look. Both are blurred by a 3 x 3 pixel tent in linear
/// light first, so that another rasteriser's edge pixels and dither don't count; then the
/// distance of each pixel's colours is taken in CIELAB (CIE76 delta E: about 2.3 is just
/// noticeable side by side).
struct PictureDifference {
  double mean = 0;          // delta E over all pixels
  double strong_share = 0;  // share of pixels above strong_delta_E
  double worst = 0;         // delta E of the worst pixel
  Picture image;            // delta E as grey to yellow over a dimmed first picture; 20 and more is full

  /// Half the distance of the skin to the tool's steel; far above what rounding does.
  static constexpr double strong_delta_E = 6;
};

/// Throws std::invalid_argument where the sizes differ.
PictureDifference difference(const Picture& a, const Picture& b);

/// Whether a viewer would call them the same picture: the mean below `max_mean` and no
/// more than `max_strong_share` of the pixels strongly different. The defaults let pass
/// other drivers' rounding, and nothing that moved by two pixels along a contour.
bool looksSame(const PictureDifference& difference, double max_mean = 0.5, double max_strong_share = 0.002);

}  // namespace palpate::app
