#include "realtime/timing/deadline_statistics.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

using palpate::DurationHistogram;

TEST_CASE("Histogram bins tile the durations, each at most 1/64 of its value wide", "[deadline_statistics]") {
  for (int b = 0; b < DurationHistogram::kBinCount; ++b) {
    const std::int64_t begin = std::llround(1e3 * DurationHistogram::binBeginUs(b));
    const std::int64_t end = std::llround(1e3 * DurationHistogram::binEndUs(b));
    REQUIRE(begin < end);
    REQUIRE(DurationHistogram::binOf(begin) == b);
    REQUIRE(DurationHistogram::binOf(end - 1) == b);
    if (b >= 64) REQUIRE(64 * (end - begin) <= begin);
  }
  CHECK(DurationHistogram::binOf(-5) == 0);
  CHECK(DurationHistogram::binOf(INT64_MAX) == DurationHistogram::kBinCount - 1);
}

TEST_CASE("Histogram percentiles are within 0.8 % of the sorted truth", "[deadline_statistics]") {
  std::mt19937_64 random(7);
  // Step times as they come: a narrow peak, a wide shoulder, rare long stalls.
  std::lognormal_distribution<double> peak(std::log(600e3), 0.05), shoulder(std::log(900e3), 0.4),
      stall(std::log(20e6), 1.0);
  std::uniform_real_distribution<double> share(0, 1);
  const auto histogram = std::make_unique<DurationHistogram>();
  std::vector<std::int64_t> all;
  for (int i = 0; i < 60'000; ++i) {
    const double s = share(random);
    const double ns = s < 0.9 ? peak(random) : s < 0.998 ? shoulder(random) : stall(random);
    all.push_back(static_cast<std::int64_t>(ns));
    histogram->add(all.back());
  }
  std::sort(all.begin(), all.end());
  for (const double p : {0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(all.size())));
    const double truth_us = 1e-3 * static_cast<double>(all[rank - 1]);
    CHECK(std::abs(histogram->percentileUs(p) - truth_us) <= 0.008 * truth_us);
  }
  CHECK(histogram->percentiles().max == 1e-3 * static_cast<double>(all.back()));
  CHECK(histogram->count() == 60'000);
}

TEST_CASE("Histograms of few values", "[deadline_statistics]") {
  const auto histogram = std::make_unique<DurationHistogram>();
  CHECK(histogram->percentiles().p999 == 0);
  histogram->add(63);
  CHECK(histogram->percentiles().p50 == Approx(0.063));
  histogram->add(1'000'000);
  CHECK(histogram->percentiles().p50 == Approx(0.063));
  CHECK(histogram->percentiles().p99 == 1000);  // the largest: exact
}
