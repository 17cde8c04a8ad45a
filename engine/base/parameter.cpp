#include "base/parameter.h"

#include <cmath>
#include <cstdlib>

#include "base/number_text.h"

namespace palpate {

std::string ValueRange::text() const {
  const bool bounded_below = std::isfinite(low), bounded_above = std::isfinite(high);
  if (bounded_below && bounded_above) {
    return (low_excluded ? "> " : "") + shortest(low) + " .. " + (high_excluded ? "< " : "") + shortest(high);
  }
  if (bounded_below) return (low_excluded ? "> " : ">= ") + shortest(low);
  if (bounded_above) return (high_excluded ? "< " : "<= ") + shortest(high);
  return "";
}

double Parameter::fallbackValue() const { return std::strtod(fallback, nullptr); }

}  // namespace palpate
