#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "mtled/identify/force_curve.h"
#include "mtled/identify/identify.h"

namespace palpate::tools {

/// What there is to say of an identification, a sentence each.
struct Remarks {
  std::vector<std::string> doubts;  // the numbers should not be believed as they stand
  std::vector<std::string> notes;
};

/// A parameter in a report: its value, its interval, and what of that is noise.
/// @param by_noise  before it was widened
inline nlohmann::json intervalOf(const Identified& found, const Identified& by_noise, std::size_t k) {
  return {{"value", found.value[k]},
          {"low_95", found.low[k]},
          {"high_95", found.high[k]},
          {"noise_low_95", by_noise.low[k]},
          {"noise_high_95", by_noise.high[k]}};
}

/// Judges what was found by what noise can't do: residuals that are too large, or follow from row to row, and a force
/// that changes while the tool is held or comes back another way. Widens the intervals to what these allow.
/// @param fall  share of the scene's force that goes while its tool is held as long as the measured one was, pressed in
///              as fast; none: its materials do not relax
Remarks judge(const MeasuredCurve& measured, std::optional<double> fall, const std::vector<SoughtParameter>& sought,
              Identified& found);

}  // namespace palpate::tools
