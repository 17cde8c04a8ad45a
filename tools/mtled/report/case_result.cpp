#include "mtled/report/case_result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "base/number_text.h"

namespace palpate::tools {
namespace {

constexpr int digits = 3;  // significant
constexpr double min_plain = 1e-3, max_plain = 1e5;

/// `value` rounded to the significant digits.
double rounded(double value) { return std::stod(format("%.*e", digits - 1, value)); }

/// Of a value that is rounded already: 1.20, 12.3, 123, 1230.
std::string plain(double value) {
  const int before_point = value == 0 ? 1 : static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  return format("%.*f", std::max(0, digits - before_point), value);
}

std::string withUnit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

bool takesPrefix(const std::string& unit) {
  static const std::array<std::string, 7> units = {"m", "N", "Pa", "s", "J", "W", "Hz"};
  return std::find(units.begin(), units.end(), unit) != units.end();
}

}  // namespace

std::string formatted(double value, const std::string& unit) {
  if (std::isnan(value)) return withUnit("NaN", unit);
  if (std::isinf(value)) return withUnit(value > 0 ? "inf" : "-inf", unit);
  if (value == 0) return withUnit("0", unit);
  const double r = rounded(value);
  if (takesPrefix(unit)) {
    static const std::array<const char*, 8> prefixes = {"p", "n", "\u00b5", "m", "", "k", "M", "G"};
    constexpr int none = 4;
    const int thousands = static_cast<int>(std::floor(std::log10(std::abs(r)) / 3 + 1e-12));
    if (thousands >= -none && thousands < static_cast<int>(prefixes.size()) - none)
      return plain(rounded(r / std::pow(1000.0, thousands))) + " " + prefixes[thousands + none] + unit;
  } else if (std::abs(r) >= min_plain && std::abs(r) < max_plain) {
    return withUnit(plain(r), unit);
  }
  return withUnit(format("%.*e", digits - 1, r), unit);
}

std::string formattedSigned(double value, const std::string& unit) {
  const std::string text = formatted(value, unit);
  return value > 0 ? "+" + text : text;
}

std::string formattedPercent(double share) { return formatted(100 * share, "%"); }

bool Bound::held() const { return at_most ? value <= limit : value >= limit; }

double Bound::use() const {
  const double part = at_most ? value : limit, whole = at_most ? limit : value;
  if (whole > 0 && std::isfinite(part)) return std::max(0.0, part / whole);
  // Without a positive limit there is no share; what is held comes last then, what is not first.
  return held() ? 0 : std::numeric_limits<double>::infinity();
}

bool CaseResult::held() const {
  return !bounds.empty() && std::all_of(bounds.begin(), bounds.end(), [](const Bound& b) { return b.held(); });
}

const Bound* CaseResult::worstBound() const {
  const auto worst = std::max_element(bounds.begin(), bounds.end(), [](const Bound& a, const Bound& b) {
    return a.held() != b.held() ? a.held() : a.use() < b.use();
  });
  return worst == bounds.end() ? nullptr : &*worst;
}

}  // namespace palpate::tools
