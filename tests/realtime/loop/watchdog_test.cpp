#include "realtime/loop/watchdog.h"

#include <catch2/catch.hpp>
#include <limits>

#include "realtime/fakes.h"

using namespace palpate;

namespace {

Model manyPoints() {
  Model model = test::smallModel();
  model.point_X.assign(1000, Vec3(1, 2, 3));
  model.point_X[400] = Vec3(0.4, 0.5, 0.6);
  return model;
}

StepReport inverted(int count) {
  StepReport report;
  report.inverted_points = count;
  report.worst_point = 400;
  report.min_J = count > 0 ? -0.1F : 0.9F;
  if (count > 0) report.flags = kInvertedPoints;
  return report;
}

}  // namespace

TEST_CASE("A displacement that is not a number is a loss at once, and the node is named", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(16);
  StepReport report;
  REQUIRE(watchdog.judge(report, 0, log) == Verdict::Good);
  report.flags = kNotFinite;
  report.worst_node = 2;
  CHECK(watchdog.judge(report, 1234, log) == Verdict::Restore);
  LogEvent event;
  REQUIRE(log.pop(event));
  CHECK(event.isRestore());
  CHECK(event.kind == LogEvent::Kind::RestoredNotFinite);
  CHECK(event.index == 2);
  CHECK(event.position == model.X[2]);
  CHECK(event.time_s == Approx(2.468));
  CHECK(logText(event).find("2.468 s: restored: the displacement of node 2 at (0.0000, 0.0200, 0.0000) m") == 0);
}

TEST_CASE("A tool force that is not a number is a loss though no flag is set", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(16);
  StepReport report;
  report.tool_force.y() = std::numeric_limits<double>::quiet_NaN();
  CHECK(watchdog.judge(report, 5, log) == Verdict::Restore);
}

TEST_CASE("A blow-up is a loss at once, and it is said how far the node went", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(16);
  StepReport report;
  report.flags = kBlowUp;
  report.worst_node = 3;
  report.max_increment = 0.25F;
  CHECK(watchdog.judge(report, 1, log) == Verdict::Restore);
  LogEvent event;
  REQUIRE(log.pop(event));
  CHECK(event.kind == LogEvent::Kind::RestoredBlowUp);
  CHECK(event.value == 0.25);
  CHECK(logText(event).find("moved 250 mm in one step") != std::string::npos);
}

TEST_CASE("Inverted points warn once, and again after a second without", "[watchdog]") {
  const Model model = manyPoints();
  LogRing log(64);
  LogEvent event;
  Watchdog watchdog(model);
  for (int t = 0; t < 2000; ++t) REQUIRE(watchdog.judge(inverted(19), t, log) == Verdict::Good);
  REQUIRE(log.size() == 1);
  log.pop(event);
  CHECK(event.isWarning());
  CHECK(event.index == 400);
  CHECK(event.position == Vec3(0.4, 0.5, 0.6));
  // Gone for more than a second (500 ticks), then again: told again.
  for (int t = 2000; t < 2600; ++t) watchdog.judge(inverted(0), t, log);
  CHECK(log.size() == 0);
  watchdog.judge(inverted(1), 2600, log);
  CHECK(log.size() == 1);
}

TEST_CASE("A full log does not keep the watchdog from its verdict", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(1);
  log.push({});
  StepReport report;
  report.flags = kNotFinite;
  CHECK(watchdog.judge(report, 0, log) == Verdict::Restore);
}

TEST_CASE("Three losses within a second are restored from, the fourth freezes - slower ones never do", "[watchdog]") {
  const Model model = manyPoints();  // 500 ticks a second
  StepReport lost;
  lost.flags = kBlowUp;
  LogRing log(256);
  {
    Watchdog watchdog(model);
    for (int k = 0; k < 3; ++k) {
      CHECK(watchdog.judge(lost, 100 * k, log) == Verdict::Restore);
      CHECK(watchdog.recentLosses() == k);
    }
    CHECK(watchdog.judge(lost, 300, log) == Verdict::Freeze);
    LogEvent event;
    while (log.pop(event)) CHECK(event.isFreeze() == (event.tick == 300));
    watchdog.reset();
    CHECK(watchdog.judge(lost, 301, log) == Verdict::Restore);
  }
  Watchdog watchdog(model);
  for (int k = 0; k < 50; ++k) CHECK(watchdog.judge(lost, 200 * k, log) == Verdict::Restore);
}
