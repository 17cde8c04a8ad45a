#include "app/figures/figure_axis.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "app/figures/round_ticks.h"
#include "base/number_text.h"

namespace palpate::app {
namespace {

constexpr double rounding = 1e-9;  // relative; an end that is a tick up to rounding counts as one

// Labels beyond these get a common factor, so that none is longer than about five characters.
constexpr double min_plain = 1e-2, max_plain = 1e5;
// Decades within these are written out ("0.01"), not as powers.
constexpr int min_plain_decade = -3, max_plain_decade = 4;

int decadeBelow(double value) { return static_cast<int>(std::floor(std::log10(value) + rounding)); }
int decadeAbove(double value) { return static_cast<int>(std::ceil(std::log10(value) - rounding)); }

void addLinearTicks(Axis& axis, int max_labels, bool superscripts) {
  const double largest = std::max(std::abs(axis.low), std::abs(axis.high));
  int exponent = 0;
  if (largest < min_plain || largest >= max_plain)
    exponent = 3 * static_cast<int>(std::floor(std::log10(largest) / 3 + rounding));
  const double factor = std::pow(10.0, exponent);
  if (exponent != 0) axis.factor = "\u00d7" + powerOfTen(exponent, superscripts);
  const std::vector<double> values = roundTicks(axis.low / factor, axis.high / factor, max_labels);
  const double step = values.size() < 2 ? axis.high / factor - axis.low / factor : values[1] - values[0];
  for (const double value : values) {
    std::string label = tickLabel(value, step);
    if (superscripts && label[0] == '-') label.replace(0, 1, "\u2212");  // a minus, not a hyphen
    axis.ticks.push_back({value * factor, label});
  }
}

void addLogTicks(Axis& axis, int max_labels, bool superscripts) {
  const int first = decadeBelow(axis.low), last = decadeAbove(axis.high);
  const double decades = std::log10(axis.high / axis.low);
  const int every = std::max(1, static_cast<int>(std::ceil((decades + 1) / max_labels)));
  const bool plain = decadeAbove(axis.low) >= min_plain_decade && decadeBelow(axis.high) <= max_plain_decade;
  // 2 and 5 get labels where the decades alone leave room for three times as many.
  const bool between = 3 * decades <= max_labels;
  for (int e = first; e <= last; ++e)
    for (int m = 1; m <= 9; ++m) {
      const double value = m * std::pow(10.0, e);
      if (value < axis.low * (1 - rounding) || value > axis.high * (1 + rounding)) continue;
      if (m > 1 && every > 1) continue;
      std::string label;
      const bool labelled = m == 1 ? e % every == 0 : between && (m == 2 || m == 5);
      if (labelled && plain) label = format("%g", value);
      if (labelled && !plain) label = (m == 1 ? "" : std::to_string(m) + "\u00d7") + powerOfTen(e, superscripts);
      axis.ticks.push_back({value, label});
    }
}

/// The largest of 1, 2, 5 times a power of ten that is at most `value`, or the least that is at least it.
double roundBelow(double value) {
  const double power = std::pow(10.0, decadeBelow(value)), m = value / power * (1 + rounding);
  return power * (m >= 5 ? 5 : m >= 2 ? 2 : 1);
}
double roundAbove(double value) { return 10 / roundBelow(10 / value); }

}  // namespace

double Axis::at(double value) const {
  if (!std::isfinite(value) || (log && value <= 0)) return std::numeric_limits<double>::quiet_NaN();
  const double t = log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return begin + t * (end - begin);
}

void Range::add(double value, bool log) {
  if (!std::isfinite(value) || (log && value <= 0)) return;
  low = empty ? value : std::min(low, value);
  high = empty ? value : std::max(high, value);
  empty = false;
}

Axis axisOver(double low, double high, bool log, int max_labels, bool superscripts) {
  Axis axis;
  axis.log = log;
  axis.low = low;
  axis.high = high;
  if (log)
    addLogTicks(axis, std::max(2, max_labels), superscripts);
  else
    addLinearTicks(axis, std::max(2, max_labels), superscripts);
  return axis;
}

Range aired(const Range& range, bool log, double share) {
  if (range.empty) return {log ? 0.1 : 0.0, 1, false};
  if (log) {
    const double air = std::pow(range.high / range.low, share);
    Range wide{range.low / air, range.high * air, false};
    if (wide.high / wide.low < 4) wide = {roundBelow(wide.low), roundAbove(wide.high), false};
    if (wide.high / wide.low < 2) wide = {wide.low / 2, wide.high * 2, false};
    return wide;
  }
  if (!(range.high > range.low)) {
    const double half = range.low == 0 ? 1 : 0.5 * std::abs(range.low);
    return {range.low - half, range.high + half, false};
  }
  const double air = share * (range.high - range.low);
  Range wide{range.low - air, range.high + air, false};
  if (range.low >= 0 && range.low < 0.25 * range.high) wide.low = 0;
  if (range.high <= 0 && range.high > 0.25 * range.low) wide.high = 0;
  return wide;
}

std::string powerOfTen(int exponent, bool superscripts) {
  if (!superscripts) return "1e" + std::to_string(exponent);
  static const char* const digits[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                       "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text = "10";
  for (const char c : std::to_string(exponent)) text += c == '-' ? "\u207b" : digits[c - '0'];
  return text;
}

}  // namespace palpate::app
