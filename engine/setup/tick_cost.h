#pragma once

#include <string>

#include "model/body.h"

namespace palpate {

/// Computing time of one integration point in one step on one thread, contact and all else included: what a tick of
/// `liver` took on two virtual cores (552 us for 20,124 points, one step, two threads: assets/frontier/README.md).
/// A count, so that the same scene is told the same everywhere; computers differ from it by a factor of two.
inline constexpr double seconds_per_point_and_step = 55e-9;

/// What a tick is expected to cost, over the time that it has.
/// @return points * steps * seconds_per_point_and_step / threads * rate
double expectedLoad(const Body& body);

/// A sentence where the scene will not hold its rate (expectedLoad above 1): how many steps a tick takes, what they
/// cost and what to do; empty: it will. For who runs against the clock.
/// Test: simulation/tick_cost_test.cpp
std::string rateWarning(const Body& body);

}  // namespace palpate
