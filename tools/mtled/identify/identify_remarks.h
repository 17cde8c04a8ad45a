#pragma once

#include "mtled/identify/force_curve.h"
#include "mtled/identify/identify.h"

namespace palpate::tools {

/// What there is to say of an identification, a sentence each.
struct Remarks {
  std::vector<std::string> doubts;  // the numbers should not be believed as they stand
  std::vector<std::string> notes;
};

/// Judges what was found by what noise can't do: residuals that are too large, or follow from row to row, and a force
/// that changes while the tool is held or comes back another way. Widens the intervals to what these allow.
/// @param relaxes  the scene's materials relax, and were pressed in as fast as the measured ones
Remarks judge(const MeasuredCurve& measured, bool relaxes, const std::vector<SoughtParameter>& sought,
              Identified& found);

}  // namespace palpate::tools
