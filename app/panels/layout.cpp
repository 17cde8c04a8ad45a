#include "app/panels/layout.h"

#include <algorithm>

namespace palpate::app {

namespace {
// px at scale 1. The columns are as wide as their longest line needs at the body font's size.
constexpr float margin = 10, bar_height = 38, left_width = 264, right_width = 344, log_height = 104;
constexpr float min_right_width = 260;  // narrower than this its numbers are cut
constexpr float min_view_width = 320, min_view_height = 200;
constexpr float view_share = 0.5F;  // of the window's width, the organ's own: a column that would take more goes
}  // namespace

Layout layoutFor(int width, int height, float scale, bool panels_shown, float overlays) {
  Layout layout;
  const float w = static_cast<float>(std::max(1, width)), h = static_cast<float>(std::max(1, height));
  const float m = margin * scale;
  layout.view = {0, 0, w, h};
  layout.panels = panels_shown;
  if (!panels_shown) return layout;

  layout.bar = {m, m, std::max(1.0F, w - 2 * m), bar_height * scale};
  const float top = layout.bar.bottom() + m;
  const float column_height = std::max(0.0F, h - top - m);
  float view_left = 0, view_right = w;
  const float view_width = std::max(min_view_width * scale, view_share * w);
  const float right = std::min(right_width * scale, w - view_width - m);
  if (right >= min_right_width * scale) {
    layout.right = {w - m - right, top, right, column_height};
    view_right = layout.right.x;
  }
  if (w >= (left_width + right_width) * scale + view_width + 2 * m) {
    layout.left = {m, top, left_width * scale, column_height};
    view_left = layout.left.right();
  }
  float view_bottom = h;
  if (h - top >= (log_height + margin + min_view_height + overlays) * scale) {
    layout.log = {view_left + m, h - m - log_height * scale, view_right - view_left - 2 * m, log_height * scale};
    view_bottom = layout.log.y;
  }
  layout.view = {view_left, top, view_right - view_left, std::max(1.0F, view_bottom - top)};
  return layout;
}

}  // namespace palpate::app
