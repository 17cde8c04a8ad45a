#pragma once

#include <algorithm>
#include <cmath>
#include <random>

namespace palpate::tools {

/// What is drawn from a seed, the same on every machine: std's distributions differ from library to library, its
/// engines do not.
class Lot {
 public:
  explicit Lot(unsigned seed) : random_(seed * 7919U + 13U) {}
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_()) / 4294967296.0);
  }
  double logBetween(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  bool chance(double share) { return between(0, 1) < share; }
  int oneOf(int count) { return std::min(count - 1, static_cast<int>(between(0, count))); }

 private:
  std::mt19937 random_;
};

}  // namespace palpate::tools
