#pragma once

#include <imgui.h>

#include <span>
#include <string>
#include <vector>

namespace palpate::app {

struct PlotPoint {
  float x = 0, y = 0;
};

/// One curve. The points are in drawing order; x need not rise (force over depth does not).
struct PlotSeries {
  const char* label = "";
  std::span<const PlotPoint> points;
  ImU32 colour = 0;
  float thickness = 1.5F;  // px at scale 1
};

/// What the axes show, in the unit that their labels name.
struct PlotAxes {
  const char* x_label = "";
  const char* y_label = "";
  double x_min = 0, x_max = 1;
  double y_min = 0, y_max = 1;
};

/// A vertical line with a name, e.g. a percentile or a budget.
struct PlotMark {
  const char* label = "";
  double x = 0;
  ImU32 colour = 0;
};

/// Curves in a frame with grid, round ticks, axis labels and a legend. Takes the
/// width of the window and `height` px. Points nearer than a pixel to the last
/// drawn one are skipped, so a long history costs no more than its pixels. Under the pointer the nearest point of a
/// curve is marked and its values are shown.
void drawPlot(const char* id, float height, const PlotAxes& axes, std::span<const PlotSeries> series);

/// Bars over equal bins from axes.x_min to axes.x_max; heights are drawn on a
/// logarithmic scale, so that single late ticks among a million stay visible.
void drawHistogram(const char* id, float height, const PlotAxes& axes, std::span<const float> counts, ImU32 colour,
                   std::span<const PlotMark> marks);

}  // namespace palpate::app
