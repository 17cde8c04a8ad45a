#include "app/figures/figure.h"

#include <algorithm>
#include <cmath>

#include "app/figures/figure_axis.h"

namespace palpate::app {

Histogram histogramOf(const std::vector<double>& values, int bin_count) {
  Range range;
  for (const double value : values) range.add(value, false);
  Histogram histogram;
  histogram.counts.assign(std::max(1, bin_count), 0.0);
  if (range.empty) return histogram;
  if (!(range.high > range.low)) range = aired(range, false, 0.1);
  histogram.low = range.low;
  histogram.high = range.high;
  Axis bins;
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

}  // namespace palpate::app
