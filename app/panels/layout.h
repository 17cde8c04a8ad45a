#pragma once

namespace palpate::app {

/// A rectangle in pixels, (0, 0) in the upper left corner of the window.
struct Rect {
  float x = 0, y = 0, width = 0, height = 0;

  float right() const { return x + width; }
  float bottom() const { return y + height; }
};

/// Where things stand in a window of a given size: two columns of panels, a bar
/// above and a log below the view between them. Nothing overlaps; all lies inside.
struct Layout {
  Rect bar;    // scene, run state, real-time factor
  Rect left;   // scene, tool, material
  Rect right;  // force, timing
  Rect log;
  Rect view;  // what is left for the organ (all of the window when panels are hidden)
  bool panels = true;
};

/// @param scale  content scale of the screen: 1 plain, 2 high-DPI
/// The organ keeps half of the width. In a window too narrow for two columns beside that the left one's panels stand in
/// the right one, below its own; that is scrolled and becomes narrower, down to 590 px of width; below, it is left out.
/// @param overlays  px at scale 1 that legend and timeline take at the foot of the view; where that leaves too little
/// of it, the log goes
Layout layoutFor(int width, int height, float scale, bool panels_shown, float overlays = 0);

inline constexpr float legend_room = 68, timeline_room = 72;  // px at scale 1, with the gap below

}  // namespace palpate::app
