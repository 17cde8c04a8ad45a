#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "app/figures/figure.h"
#include "app/figures/figure_axis.h"
#include "app/figures/paper.h"
#include "app/render/theme.h"

namespace palpate::app {

inline bool hasLine(SeriesStyle style) { return style != SeriesStyle::Points; }
inline bool hasPoints(SeriesStyle style) { return style == SeriesStyle::Points || style == SeriesStyle::LineAndPoints; }

/// One figure on its way onto a draw list: axes from the data, then what is drawn, then
/// labels and legend where they cover least of it. Lives for one picture.
class FigureSheet {
 public:
  FigureSheet(ImDrawList& draw, const Theme& theme, const Figure& figure, int width, int height);

  /// The bands are a histogram's bars: in full colour without outline, over counts, which
  /// have no values below 1.
  void bandsAreBars() { band_opacity_ = 1; }

  void draw();

  const Axis& x() const { return x_; }
  const Axis& y() const { return y_; }

 private:
  static constexpr float legend_sample = 20, legend_gap = 6, legend_pad = 7;  // units of length

  struct Entry {
    const Series* series = nullptr;  // or a band
    int colour = 0, shape = 0;
    std::string label;
  };
  struct Label {
    Box box;
    ImU32 colour = 0;
    std::string text;
  };

  void layOut(float legend_height);
  void takePlaces();
  void placePointLabels();
  void placeMarkLabels();
  bool place(const std::vector<Box>& choices, ImU32 colour, const std::string& text);
  bool findLegendPlace();
  double covered(const Box& box) const;

  void drawAxes();
  void drawBands();
  void drawSeries();
  void drawSeries(const Series& series, ImU32 colour, int shape);
  void drawMarks();
  void drawLegend();

  ImVec2 at(double x, double y) const;
  std::vector<std::vector<ImVec2>> runs(const Series& series) const;
  ImU32 colourOf(int index) const;
  float legendWidth(const Entry& entry) const;
  float legendRowsHeight() const;

  ImDrawList& draw_;
  const Theme& theme_;
  const Figure& figure_;
  Box sheet_, frame_;
  Axis x_, y_;
  float s_;  // px of a unit of length
  double band_opacity_ = 0.16;
  std::vector<int> colours_, shapes_;  // (series) palette index, marker
  std::vector<Entry> entries_;         // of the legend
  std::vector<ImVec2> inked_;          // where data stand, densely along lines
  std::vector<Label> labels_;          // of points and marks
  Box legend_;
  bool legend_inside_ = false;
};

}  // namespace palpate::app
