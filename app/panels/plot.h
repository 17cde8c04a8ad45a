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

/// Round values (1, 2 or 5 times a power of ten apart) inside [low, high], at most
/// `max_count` of them. Empty where high <= low or either is not finite.
std::vector<double> roundTicks(double low, double high, int max_count);

/// A tick's label with as many digits as tell it from its neighbours `step` away.
std::string tickLabel(double value, double step);

/// Widens [low, high] to the next round values, so that an axis does not twitch with
/// every sample; a range narrower than `least` is widened to it.
void widenToRound(double& low, double& high, double least);

/// Curves in a frame with grid, round ticks, axis labels and a legend. Takes the
/// width of the window and `height` px. Points nearer than a pixel to the last
/// drawn one are skipped, so a long history costs no more than its pixels.
void drawPlot(const char* id, float height, const PlotAxes& axes, std::span<const PlotSeries> series);

/// Bars over equal bins from axes.x_min to axes.x_max; heights are drawn on a
/// logarithmic scale, so that single late ticks among a million stay visible.
void drawHistogram(const char* id, float height, const PlotAxes& axes, std::span<const float> counts, ImU32 colour,
                   std::span<const PlotMark> marks);

}  // namespace palpate::app
