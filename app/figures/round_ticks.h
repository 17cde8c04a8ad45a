#pragma once

#include <string>
#include <vector>

namespace palpate::app {

/// Round values (1, 2 or 5 times a power of ten apart) inside [low, high], at most
/// `max_count` of them. Empty where high <= low or either is not finite.
std::vector<double> roundTicks(double low, double high, int max_count);

/// A tick's label with as many digits as tell it from its neighbours `step` away.
std::string tickLabel(double value, double step);

/// Widens [low, high] to the next round values, so that an axis does not twitch with
/// every sample; a range narrower than `least` is widened to it.
void widenToRound(double& low, double& high, double least);

}  // namespace palpate::app
