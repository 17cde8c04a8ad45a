#include "mtled/bench/roofline.h"

#include <algorithm>
#include <cmath>

namespace palpate::tools {

Figure rooflineOf(const BenchReport& report) {
  constexpr double least = 0.5, most = 32;  // flops per byte; the kernels lie between 1 and 6
  const Ceilings& one = report.ceilings.front();
  const double peak = one.mostGflops();
  Figure figure;
  figure.title = "One core, " + report.machine.processor;
  figure.x_label = "Useful flops per byte streamed";
  figure.y_label = "Useful GFLOP/s";
  figure.log_x = figure.log_y = true;
  figure.x_low = least;
  figure.x_high = most;
  for (const MemoryLevel& level : one.levels) {
    const double ridge = std::clamp(peak / level.gb_per_s, least, most);
    Series roof;
    roof.label = level.name + " roof";
    for (const double x : {least, ridge, most}) {
      roof.x.push_back(x);
      roof.y.push_back(std::min(peak, x * level.gb_per_s));
    }
    figure.series.push_back(roof);
  }
  for (const BenchBodyResult& body : report.bodies) {
    Series points;
    points.label = body.name + " nodes";
    points.style = SeriesStyle::Points;
    for (const BenchRow& row : body.rows) {
      if (row.threads != 1 || !std::isfinite(row.bytes)) continue;
      points.x.push_back(row.useful_flops / row.bytes);
      points.y.push_back(row.gflop_per_s);
      points.point_labels.push_back(row.kernel + ", " + row.precision);
    }
    figure.series.push_back(points);
  }
  return figure;
}

}  // namespace palpate::tools
