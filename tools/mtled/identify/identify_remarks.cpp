#include "mtled/identify/identify_remarks.h"

#include <algorithm>
#include <cmath>

#include "base/number_text.h"

namespace palpate::tools {
namespace {

// Shares of the largest force.
constexpr double most_noise = 0.1;        // no scale for forces is as bad
constexpr double most_structure = 0.03;   // of a scene that follows a curve: that of a cloud coarser by half is 0.01
constexpr double told_structure = 0.005;  // less is told apart from noise, and of no weight
constexpr double most_change = 0.03;      // of a force that had settled

}  // namespace

Remarks judge(const MeasuredCurve& measured, std::optional<double> fall, const std::vector<SoughtParameter>& sought,
              Identified& found) {
  Remarks remarks;
  const double largest = *std::max_element(measured.force.begin(), measured.force.end());
  if (!found.told_apart)
    remarks.notes.emplace_back(sought.size() > 1 ? "the curve does not tell the parameters apart: give one, or measure "
                                                   "deeper or with another tool"
                                                 : "the curve hardly says what the parameter is: measure deeper or "
                                                   "with another tool");
  std::string shifted;
  if (found.structure > told_structure * largest) {
    widenToHalves(sought, found);
    const double offset = widenForOffset(std::vector<double>(measured.force.size(), 1), sought, found);
    const double shift = widenForShift(measured.depth, measured.force, sought, found);
    if (shift != 0)
      shifted = format(" Depths that count from %.2g mm %s the touch would explain it: is 0 where the tool touches?",
                       1e3 * std::abs(shift), shift > 0 ? "before" : "after");
    if (offset != 0)
      shifted += format(" Forces that are all %.2g N too %s would explain it: is 0 that of the tool in air?",
                        std::abs(offset), offset > 0 ? "small" : "large");
  }
  if (found.misfit > most_noise * largest || found.structure > most_structure * largest)
    remarks.doubts.push_back(format("the scene can't follow this curve: %.3g %% of the largest force are left over, "
                                    "which is no noise. Try another law or more of its parameters; are tool, support "
                                    "and size those of the experiment?",
                                    100 * found.misfit / largest) +
                             shifted);
  else if (found.structure > told_structure * largest)
    remarks.notes.push_back(
        format("the residuals follow from row to row, by %.2g %% of the largest force, which is no "
               "noise: a curve that had not settled does so, another law, or another of the scene's materials. The "
               "interval reaches to what each half of "
               "the curve says",
               100 * found.structure / largest) +
        (shifted.empty() ? "" : "." + shifted));
  if (fall) {  // change in time is the scene's own: as much of it?
    const bool is_noise = measured.fall == 0 && found.misfit > most_change * largest;
    if (!(measured.held_seconds > 0) || is_noise) return remarks;
    const double apart = measured.fall - *fall;
    std::vector<double> change;
    for (const double force : measured.force) change.push_back(-apart * force);
    widenFor(change, sought, found);
    if (std::abs(apart) > most_change)
      remarks.doubts.push_back(
          format("while the tool was held the force fell by %.2g %%, and that of the scene by %.2g "
                 "%%: its \"relaxation\" is another. The interval reaches to what fits then",
                 100 * measured.fall, 100 * *fall));
    return remarks;
  }
  if (measured.change.empty()) {
    remarks.notes.emplace_back(
        "a curve that only goes in does not show whether it had settled: where the tissue may "
        "relax, hold the tool at its deepest, or measure its way out, too");
    return remarks;
  }
  widenFor(measured.change, sought, found);
  double most = 0;
  for (const double change : measured.change) most = std::max(most, std::abs(change));
  if (most > most_change * largest)
    remarks.doubts.push_back(
        format("the curve had not settled: while the tool was held or on its way out, the force "
               "came to lie %.2g %% of the largest from that on the way in. The interval reaches "
               "to what fits it then; press more slowly, or give the material its \"relaxation\"",
               100 * most / largest));
  return remarks;
}

}  // namespace palpate::tools
