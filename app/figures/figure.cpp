#include "app/figures/figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "app/figures/canvas.h"
#include "app/figures/figure_sheet.h"

namespace palpate::app {

Histogram histogramOf(const std::vector<double>& values, int bin_count, bool log_x) {
  Range range;
  for (const double value : values) range.add(value, log_x);
  Histogram histogram;
  histogram.log_x = log_x;
  histogram.counts.assign(std::max(1, bin_count), 0.0);
  if (range.empty) return histogram;
  if (!(range.high > range.low)) range = aired(range, log_x, 0.1);
  histogram.low = range.low;
  histogram.high = range.high;
  Axis bins;
  bins.log = log_x;
  bins.low = range.low;
  bins.high = range.high;
  bins.end = static_cast<double>(histogram.counts.size());
  for (const double value : values) {
    const double place = bins.at(value);
    if (std::isnan(place)) continue;
    ++histogram.counts[std::min(static_cast<std::size_t>(std::max(0.0, place)), histogram.counts.size() - 1)];
  }
  return histogram;
}

std::vector<int> paretoFront(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<int> order;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i])) order.push_back(static_cast<int>(i));
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return x[a] != x[b] ? x[a] < x[b] : y[a] < y[b]; });
  std::vector<int> front;
  for (const int i : order)
    if (front.empty() || y[i] < y[front.back()]) front.push_back(i);
  return front;
}

FigureWriter::FigureWriter() : canvas_(std::make_unique<Canvas>()) {}
FigureWriter::~FigureWriter() = default;

DrawnFigure FigureWriter::draw(const Figure& figure, int width, int height) {
  for (const Series& series : figure.series)
    if (series.x.size() != series.y.size() ||
        (!series.point_labels.empty() && series.point_labels.size() != series.x.size()))
      throw std::invalid_argument("figure '" + figure.title + "': series '" + series.label +
                                  "' has x, y or point labels of different lengths");
  for (const Band& band : figure.bands)
    if (band.low.size() != band.x.size() || band.high.size() != band.x.size())
      throw std::invalid_argument("figure '" + figure.title + "': band '" + band.label +
                                  "' has x, low and high of different lengths");
  ImDrawList& list = canvas_->begin(width, height);
  FigureSheet sheet(list, canvas_->theme(), figure, width, height);
  sheet.draw();
  return {canvas_->end(), sheet.x(), sheet.y()};
}

DrawnFigure FigureWriter::draw(const Histogram& histogram, int width, int height) {
  // Bars are bands without a name, one after the other.
  Figure figure;
  figure.title = histogram.title;
  figure.x_label = histogram.x_label;
  figure.y_label = histogram.y_label;
  figure.log_x = histogram.log_x;
  figure.log_y = histogram.log_counts;
  figure.x_low = histogram.low;
  figure.x_high = histogram.high;
  figure.marks = histogram.marks;
  const double foot = histogram.log_counts ? 0.7 : 0;  // below a single count, so that it can be seen
  double largest = 1;
  for (const double count : histogram.counts) largest = std::max(largest, count);
  figure.y_low = foot;
  figure.y_high = histogram.log_counts ? largest * std::pow(largest / foot, 0.15) : 1.15 * largest;
  Axis bins;
  bins.log = histogram.log_x;
  bins.low = histogram.low;
  bins.high = histogram.high;
  const double bin_count = static_cast<double>(histogram.counts.size());
  const auto edge = [&](double k) {
    const double t = k / bin_count;
    return bins.log ? bins.low * std::pow(bins.high / bins.low, t) : bins.low + t * (bins.high - bins.low);
  };
  for (std::size_t k = 0; k < histogram.counts.size(); ++k) {
    if (!(histogram.counts[k] > 0)) continue;
    const double count = histogram.counts[k];
    figure.bands.push_back({"", {edge(k + 0.06), edge(k + 0.94)}, {foot, foot}, {count, count}, histogram.colour});
  }
  ImDrawList& list = canvas_->begin(width, height);
  FigureSheet sheet(list, canvas_->theme(), figure, width, height);
  sheet.bandsAreBars();
  sheet.draw();
  return {canvas_->end(), sheet.x(), sheet.y()};
}

void FigureWriter::write(const std::string& png, const Figure& figure, int width, int height) {
  writePng(png, draw(figure, width, height).picture);
}

void FigureWriter::write(const std::string& png, const Histogram& histogram, int width, int height) {
  writePng(png, draw(histogram, width, height).picture);
}

}  // namespace palpate::app
