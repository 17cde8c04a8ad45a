#include "app/figures/round_ticks.h"

#include <algorithm>
#include <cmath>

#include "base/number_text.h"

namespace palpate::app {
namespace {

double roundStep(double raw) {
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double m = raw / power;  // 1 <= m < 10
  return power * (m <= 1.000001 ? 1 : m <= 2.000001 ? 2 : m <= 5.000001 ? 5 : 10);
}

}  // namespace

std::vector<double> roundTicks(double low, double high, int max_count) {
  std::vector<double> ticks;
  if (!std::isfinite(low) || !std::isfinite(high) || high <= low || max_count < 1) return ticks;
  const double step = roundStep((high - low) / max_count);
  const double tolerance = 1e-9 * (high - low);  // so that an end that is a tick up to rounding counts
  const auto first = static_cast<long long>(std::ceil((low - tolerance) / step));
  for (long long k = first; static_cast<double>(k) * step <= high + tolerance; ++k)
    ticks.push_back(static_cast<double>(k) * step);
  return ticks;
}

std::string tickLabel(double value, double step) {
  const int decimals = step > 0 ? std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9) : 0;
  return format("%.*f", decimals, value == 0 ? 0.0 : value);
}

void widenToRound(double& low, double& high, double least) {
  if (!std::isfinite(low) || !std::isfinite(high) || high < low) low = high = 0;
  if (high - low < least) high = low + least;
  const double step = roundStep((high - low) / 4);
  low = std::floor(low / step + 1e-9) * step;
  high = std::ceil(high / step - 1e-9) * step;
}

}  // namespace palpate::app
