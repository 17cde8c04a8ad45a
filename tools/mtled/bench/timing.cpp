#include "mtled/bench/timing.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <stdexcept>

#include "base/interrupt.h"

namespace palpate::tools {

double TimedCall::best() const {
  return seconds.empty() ? std::numeric_limits<double>::quiet_NaN() : *std::min_element(seconds.begin(), seconds.end());
}

double TimedCall::median() const {
  if (seconds.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted = seconds;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

void timeInTurns(std::vector<TimedCall>& calls, double seconds) {
  using Clock = std::chrono::steady_clock;
  constexpr int turns = 10;
  constexpr double shortest_turn = 0.004;  // s: long enough for the clock rate to settle on wide registers
  const double turn = std::max(shortest_turn, seconds / turns);
  const int turn_count = std::max(3, static_cast<int>(seconds / turn));
  for (int t = 0; t < turn_count; ++t)
    for (TimedCall& timed : calls) {
      if (interrupted())
        throw std::runtime_error(
            "interrupted; bodies that were done are above, and in the JSON file if one was asked for");
      timed.team->wake();
      timed.call();
      const auto end = Clock::now() + std::chrono::duration<double>(turn);
      do {
        const auto start = Clock::now();
        timed.call();
        timed.seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
      } while (Clock::now() < end);
      timed.team->park();
    }
}

}  // namespace palpate::tools
