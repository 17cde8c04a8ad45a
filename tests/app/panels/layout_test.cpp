#include "app/panels/layout.h"

#include <catch2/catch.hpp>

#include <utility>
#include <vector>

using namespace palpate;
using namespace palpate::app;

namespace {

bool overlap(const Rect& a, const Rect& b) {
  return a.width > 0 && b.width > 0 && a.x < b.right() && b.x < a.right() && a.y < b.bottom() && b.y < a.bottom();
}

}  // namespace

TEST_CASE("Nothing overlaps and all lies inside the window, at any size and scale", "[layout]") {
  for (float scale : {1.0F, 1.5F, 2.0F})
    for (int width : {640, 800, 1024, 1280, 1920, 3840})
      for (int height : {400, 480, 800, 1080, 2160}) {
        const Layout layout = layoutFor(width, height, scale, true);
        const std::vector<Rect> parts{layout.bar, layout.left, layout.right, layout.log, layout.view};
        INFO(width << "x" << height << " at " << scale);
        for (std::size_t i = 0; i < parts.size(); ++i) {
          if (parts[i].width <= 0) continue;  // left out
          CHECK(parts[i].x >= 0);
          CHECK(parts[i].y >= 0);
          CHECK(parts[i].right() <= static_cast<float>(width) + 0.01F);
          CHECK(parts[i].bottom() <= static_cast<float>(height) + 0.01F);
          for (std::size_t j = 0; j < i; ++j) CHECK_FALSE(overlap(parts[i], parts[j]));
        }
        CHECK(layout.view.width >= 320 * scale - 0.01F - (static_cast<float>(width) < 340 * scale ? 1e6F : 0));
      }
}

TEST_CASE("The default window has all panels - hidden panels leave all to the view", "[layout]") {
  const Layout shown = layoutFor(1280, 800, 1, true);
  CHECK(shown.left.width > 0);
  CHECK(shown.right.width > 0);
  CHECK(shown.log.width > 0);
  const Layout hidden = layoutFor(1280, 800, 1, false);
  CHECK(hidden.view.width == 1280);
  CHECK(hidden.view.height == 800);
}

TEST_CASE("The organ keeps half of the window's width", "[layout]") {
  for (int width = 660; width <= 1920; width += 10)
    CHECK(layoutFor(width, 700, 1, true).view.width >= 0.5F * static_cast<float>(width) - 0.01F);
}

TEST_CASE("Where legend and timeline leave the organ too little, the log goes", "[layout]") {
  const float both = legend_room + timeline_room;
  CHECK(layoutFor(640, 400, 1, true).log.width > 0);
  const Layout small = layoutFor(640, 400, 1, true, both);
  CHECK(small.log.width == 0);
  CHECK(small.view.height - both > 180);
  CHECK(layoutFor(900, 600, 1, true, both).log.width > 0);
}

TEST_CASE("The force stays in sight down to 640x400, and all panels can be reached at 900x600", "[layout]") {
  for (const auto& [width, height] : {std::pair{900, 600}, {640, 400}}) {
    const Layout layout = layoutFor(width, height, 1, true);
    CHECK(layout.right.width >= 260);  // with the left column's panels below its own
    CHECK(layout.bar.width > 0);
  }
}
