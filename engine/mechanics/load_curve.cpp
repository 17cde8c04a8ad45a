#include "mechanics/load_curve.h"

#include <algorithm>

namespace palpate {

double LoadCurve::at(double time_s, double duration) const {
  if (kind == Kind::Table) {
    const auto after = std::upper_bound(time.begin(), time.end(), time_s);
    if (after == time.begin()) return fraction.front();
    if (after == time.end()) return fraction.back();
    const auto k = static_cast<std::size_t>(after - time.begin());
    const double s = (time_s - time[k - 1]) / (time[k] - time[k - 1]);
    return fraction[k - 1] + s * (fraction[k] - fraction[k - 1]);
  }
  const double t = duration > 0 ? std::clamp(time_s / duration, 0.0, 1.0) : (time_s > 0 ? 1.0 : 0.0);
  return kind == Kind::Linear ? t : t * t * t * (10 + t * (-15 + 6 * t));
}

}  // namespace palpate
