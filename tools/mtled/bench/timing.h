#pragma once

#include <functional>
#include <vector>

#include "base/spin_team.h"

namespace palpate::tools {

/// Something whose time is taken again and again, and the times so far.
struct TimedCall {
  SpinTeam* team = nullptr;  // awake while its calls are timed
  std::function<void()> call;
  std::vector<double> seconds{};  // of each timed call

  double best() const;  // the machine's noise only ever adds
  double median() const;
};

/// Times all calls in turns of a few milliseconds at least, until each has had about `seconds`: what disturbs
/// the machine for a while disturbs them all, so that their ratios hold. A turn's first call is not
/// counted, for it finds the caches full of its predecessor's data. Each has 3 times or more.
/// Throws std::runtime_error where the user interrupts.
void timeInTurns(std::vector<TimedCall>& calls, double seconds);

}  // namespace palpate::tools
