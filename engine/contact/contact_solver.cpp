#include "contact/contact_solver.h"

#include <algorithm>
#include <array>

#include "contact/skin_rows.h"

namespace palpate {
namespace {

/// Sweeps at most. Warm-started contacts on tissue need one to five, where a tool gives way some 20, a kidney at rest
/// on a table 8 to 14. (Ended after 8 whatever they have come to, a node on the table trembles at 20 mm/s for ever, and
/// friction lets go of it by and by.)
constexpr int most_sweeps = 32;

/// Until each group has little to change after all others have settled. @return sweeps
template <std::size_t count>
int sweepAll(const std::array<ContactGroup*, count>& groups) {
  std::array<bool, count> settled{};
  std::size_t present = 0;
  for (std::size_t g = 0; g < count; ++g) {
    settled[g] = groups[g]->makeRows() == 0;
    present += settled[g] ? 0 : 1;
  }
  const std::array<bool, count> absent = settled;
  bool done = present == 0;
  int sweep = 0;
  for (; sweep < most_sweeps && !done; ++sweep) {
    const bool again = std::find(settled.begin(), settled.end(), false) == settled.end();
    done = again || present == 1;
    for (std::size_t g = 0; g < count; ++g) {
      if (absent[g] || (settled[g] && !again)) continue;
      settled[g] = groups[g]->sweep(sweep % 2 == 0);
      done &= settled[g];
    }
  }
  return sweep;
}

}  // namespace

ContactForces solveContacts(const ContactStep& step, const Touching& touching) {
  ToolRows tools(step, touching.tools);
  SkinRows skins(step, touching.skins, touching.pairs);
  RigidRows rigid(step, touching.rigid, touching.begin, touching.end, touching.rigid_state);
  if (touching.held != nullptr) touching.held->makeRows();
  const int sweeps = sweepAll(std::array<ContactGroup*, 3>{&tools, &skins, &rigid});
  tools.finish();
  return {skins.finish(), rigid.finish(), sweeps};
}

}  // namespace palpate
