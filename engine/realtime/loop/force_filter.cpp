#include "realtime/loop/force_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate {

ForceFilter::ForceFilter(double cutoff_hz, double rate_limit, double rate_hz)
    : gain_(cutoff_hz > 0 ? -std::expm1(-2 * std::numbers::pi * cutoff_hz / rate_hz) : 1.0),
      max_change_(rate_limit > 0 ? rate_limit / rate_hz : std::numeric_limits<double>::infinity()),
      rate_hz_(rate_hz) {}

Vec3 ForceFilter::update(const Vec3& raw) {
  if (fade_tick_ > 0) {  // out of a freeze: go on from where the ramp is
    fade_tick_ = 0;
    low_pass_ = out_;
  }
  low_pass_ += gain_ * (raw - low_pass_);
  const Vec3 change = low_pass_ - out_;
  const double size = change.norm();
  if (size > max_change_) {
    out_ += (max_change_ / size) * change;
  } else {
    out_ = low_pass_;
  }
  return out_;
}

Vec3 ForceFilter::fade() {
  // The ramp 1 - 3 s^2 + 2 s^3 is steepest in its middle: 3/2 of its mean slope.
  constexpr double kSteepest = 1.5;
  if (fade_tick_ == 0) {
    fade_from_ = out_;
    const double ticks = std::max(fade_seconds * rate_hz_, kSteepest * fade_from_.norm() / max_change_);
    fade_ticks_ = static_cast<int>(std::ceil(std::max(ticks, 1.0)));
  }
  fade_tick_ = std::min(fade_tick_ + 1, fade_ticks_);
  const double s = static_cast<double>(fade_tick_) / fade_ticks_;
  out_ = (1 - s * s * (3 - 2 * s)) * fade_from_;
  return out_;
}

}  // namespace palpate
