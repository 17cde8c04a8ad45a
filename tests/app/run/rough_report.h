#pragma once

#include "app/run/rough_motion.h"
#include "app/run/soak_report.h"
#include "realtime/loop/simulation_loop.h"

namespace palpate::test {

/// What a soak would report of a run under a rough hand: its cycles, and how the run went.
inline app::SoakReport roughReport(app::RoughMotion& motion, const RunSummary& summary) {
  app::SoakReport report;
  report.rough = true;
  report.organ_size_m = motion.rest().organSize();
  report.frozen = summary.frozen;
  report.restored = summary.restored_count;
  report.restores = summary.restores;
  report.let_go = summary.let_go_count;
  report.ticks = summary.ticks;
  for (app::SoakCycle cycle; motion.cycles().pop(cycle);) addCycle(report, cycle);
  return report;
}

}  // namespace palpate::test
