#include "app/figures/figure_writer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "app/figures/canvas.h"
#include "app/figures/figure_sheet.h"

namespace palpate::app {

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
  figure.log_y = histogram.log_counts;
  figure.x_low = histogram.low;
  figure.x_high = histogram.high;
  figure.marks = histogram.marks;
  const double foot = histogram.log_counts ? 0.7 : 0;  // below a single count, so that it can be seen
  double largest = 1;
  for (const double count : histogram.counts) largest = std::max(largest, count);
  figure.y_low = foot;
  figure.y_high = histogram.log_counts ? largest * std::pow(largest / foot, 0.15) : 1.15 * largest;
  const double bin_count = static_cast<double>(histogram.counts.size());
  const auto edge = [&](double k) { return histogram.low + k / bin_count * (histogram.high - histogram.low); };
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
