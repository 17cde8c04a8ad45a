#pragma once

#include <optional>
#include <string>
#include <vector>

// What figures show, as plain data: who only describes figures needs nothing that draws them (figure_writer.h).

namespace palpate::app {

/// How a series is drawn. Step: level from each point to the next one's x, then up or down.
enum class SeriesStyle { Line, Dashed, Points, LineAndPoints, Step };

/// A colour-blind-safe palette (Okabe and Ito 2008) without its yellow, which paper swallows.
inline constexpr int figure_colour_count = 6;
inline constexpr int ink_colour = -2;   // near black, for a reference
inline constexpr int next_colour = -1;  // the palette's next, in the figure's order

/// One curve or cloud of points, in drawing order. NaN, and values <= 0 on a logarithmic axis,
/// break the line.
struct Series {
  std::string label;         // empty: not in the legend
  std::vector<double> x, y;  // (point_count) each, in the unit that the axis names
  SeriesStyle style = SeriesStyle::Line;
  int colour = next_colour;                 // 0..figure_colour_count - 1, or one of the two above
  std::vector<std::string> point_labels{};  // empty, or (point_count); written beside the points where there is room
  std::vector<int> highlighted{};           // points with a ring, e.g. of paretoFront()
};

/// An area between two curves, e.g. what a reference allows or a scatter of runs.
struct Band {
  std::string label;
  std::vector<double> x, low, high;  // (point_count) each
  int colour = ink_colour;
};

/// A line across the figure with its name beside it, e.g. a limit.
struct Mark {
  std::string label;
  double value = 0;  // x, or y of a horizontal one
  bool horizontal = false;
  int colour = ink_colour;
};

struct Figure {
  std::string title;             // may be empty
  std::string x_label, y_label;  // with unit: "Extension, mm"
  bool log_x = false, log_y = false;
  std::optional<double> x_low, x_high, y_low, y_high;  // else from the data
  std::vector<Series> series;
  std::vector<Band> bands;
  std::vector<Mark> marks;
};

/// Bars over bins that are equally wide on the x axis.
struct Histogram {
  std::string title, x_label, y_label = "Count";
  bool log_counts = true;      // single late values among many stay visible
  double low = 0, high = 1;    // of all bins
  std::vector<double> counts;  // (bin_count)
  std::vector<Mark> marks;
  int colour = 0;
};

/// Counts of the finite values, in bins over their whole range.
Histogram histogramOf(const std::vector<double>& values, int bin_count);

/// The points than which no other is at most as large in both x and y, by rising x: what a
/// Step series joins. NaN never belongs to it.
std::vector<int> paretoFront(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace palpate::app
