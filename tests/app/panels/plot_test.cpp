#include "app/figures/round_ticks.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "app/panels/force_history.h"

using namespace palpate;
using namespace palpate::app;

TEST_CASE("Ticks are round, inside the range, evenly spaced and not too many", "[plot]") {
  for (const auto& [low, high] : {std::pair{0.0, 1.0}, {-3.7, 8.2}, {0.0012, 0.0047}, {0.0, 1e6}, {-5.0, -1.0}}) {
    for (int most : {2, 4, 7}) {
      const auto ticks = roundTicks(low, high, most);
      REQUIRE_FALSE(ticks.empty());
      CHECK(ticks.size() <= static_cast<std::size_t>(most) + 1);  // n spaces have n + 1 ends
      CHECK(ticks.front() >= low - 1e-9 * (high - low));
      CHECK(ticks.back() <= high + 1e-9 * (high - low));
      if (ticks.size() < 2) continue;
      const double step = ticks[1] - ticks[0];
      const double leading = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
      CHECK((std::abs(leading - 1) < 1e-6 || std::abs(leading - 2) < 1e-6 || std::abs(leading - 5) < 1e-6));
    }
  }
  CHECK(roundTicks(1, 1, 5).empty());
  CHECK(roundTicks(0, std::numeric_limits<double>::quiet_NaN(), 5).empty());
  CHECK(roundTicks(0, std::numeric_limits<double>::infinity(), 5).empty());
}

TEST_CASE("A tick's label has the digits that tell it from its neighbours", "[plot]") {
  CHECK(tickLabel(0.5, 0.5) == "0.5");
  CHECK(tickLabel(1, 0.25) == "1.0");
  CHECK(tickLabel(0.02, 0.01) == "0.02");
  CHECK(tickLabel(1500, 500) == "1500");
  CHECK(tickLabel(-0.0, 1) == "0");
}

TEST_CASE("An axis is widened to round values that hold the data", "[plot]") {
  double low = -0.03, high = 1.234;
  widenToRound(low, high, 0.05);
  CHECK(low <= -0.03);
  CHECK(high >= 1.234);
  CHECK(high - low < 2 * (1.234 + 0.03));

  low = high = 0;
  widenToRound(low, high, 0.05);
  CHECK(low == 0);
  CHECK(high >= 0.05);
  CHECK(high < 0.1);

  low = std::numeric_limits<double>::quiet_NaN();
  high = 1;
  widenToRound(low, high, 0.05);
  CHECK(std::isfinite(low));
  CHECK(high > low);
}

TEST_CASE("The force history keeps its last seconds, peaks of all, and begins anew after a reset", "[plot]") {
  ForceHistory history(1.0);
  ForceSample sample;
  const auto add = [&](double time, double newton) {
    sample.time_s = time;
    sample.depth_m = 0.001 * time;
    sample.force_raw = {0, 0, newton};
    sample.force_filtered = {0, 0.5 * newton, 0};
    history.add(sample);
  };
  for (int k = 0; k <= 10000; ++k) add(0.001 * k, k == 1234 ? 7.0 : 1.0);
  CHECK(history.peakRaw() == 7);
  CHECK(history.peakFiltered() == 3.5);
  const auto raw = history.rawOverTime();
  CHECK(raw.size() == Approx(1000).margin(2));
  CHECK(raw.front().x == Approx(9.0).margin(2e-3));
  CHECK(raw.back().x == Approx(10.0));
  CHECK(history.filteredOverDepth().back().x == Approx(10.0));  // mm
  CHECK(history.filteredOverDepth().back().y == Approx(0.5));
  CHECK(history.rawOverDepth().size() == raw.size());

  add(10.0, 99);  // the same tick once more: nothing new
  CHECK(history.peakRaw() == 7);
  add(0.0, 0.25);
  CHECK(history.rawOverTime().size() == 1);
  CHECK(history.peakRaw() == 0.25);
}
