#include "app/panels/press_curves.h"

#include <algorithm>
#include <cmath>

#include "base/number_text.h"

namespace palpate::app {

namespace {
constexpr int air_ticks = 50;         // without force: the tool has left the skin, and does not just hop
constexpr float least_mm = 0.02F;     // between two points of a curve,
constexpr float least_share = 0.01F;  // or this share of the peak
}  // namespace

void PressCurves::clear() {
  presses_.clear();
  under_way_ = false;
  air_ = 0;
}

void PressCurves::add(const ForceSample& sample) {
  const double force = sample.force_raw.norm();
  if (!std::isfinite(force) || !std::isfinite(sample.depth_m)) return;
  if (force <= 0) {
    if (!under_way_ || ++air_ < air_ticks) return;
    under_way_ = false;
    if (presses_.back().peak_N < least_N) presses_.pop_back();
    return;
  }
  air_ = 0;
  if (!under_way_) {
    under_way_ = true;
    presses_.push_back({++number_, sample.time_s, 0, 0, 0, 0, {}});
    if (presses_.size() > most_kept) presses_.pop_front();
  }
  Press& press = presses_.back();
  const PlotPoint point{static_cast<float>(1e3 * sample.depth_m), static_cast<float>(force)};
  if (!press.curve.empty()) {
    const double work = 0.5 * (static_cast<double>(last_.y) + force) *
                        (static_cast<double>(point.x) - static_cast<double>(last_.x));  // N mm
    press.loaded_mJ += std::max(0.0, work);
    press.lost_mJ += work;
  }
  last_ = point;
  press.peak_N = std::max(press.peak_N, force);
  press.peak_mm = std::max(press.peak_mm, static_cast<double>(point.x));
  const bool apart = press.curve.empty() || std::abs(point.x - press.curve.back().x) >= least_mm ||
                     std::abs(point.y - press.curve.back().y) >= least_share * static_cast<float>(press.peak_N);
  if (apart && press.curve.size() < most_points) press.curve.push_back(point);
}

std::string PressCurves::csv() const {
  std::string text = "press,time_begin_s,depth_mm,force_N\n";
  for (const Press& press : presses_)
    for (const PlotPoint& p : press.curve)
      text += format("%d,%.4f,%.5g,%.6g\n", press.number, press.begin_s, static_cast<double>(p.x),
                     static_cast<double>(p.y));
  return text;
}

}  // namespace palpate::app
