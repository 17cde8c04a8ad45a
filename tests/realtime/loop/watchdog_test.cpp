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

TEST_CASE("A displacement that is not a number freezes at once and names the node", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(16);
  StepReport report;
  REQUIRE_FALSE(watchdog.judge(report, 0, log));
  report.flags = kNotFinite;
  report.worst_node = 2;
  CHECK(watchdog.judge(report, 1234, log));
  LogEvent event;
  REQUIRE(log.pop(event));
  CHECK(event.isFreeze());
  CHECK(event.kind == LogEvent::Kind::FrozenNotFinite);
  CHECK(event.index == 2);
  CHECK(event.position == model.X[2]);
  CHECK(event.time_s == Approx(2.468));
  CHECK(logText(event).find("2.468 s: frozen: the displacement of node 2 at (0.0000, 0.0200, 0.0000) m") == 0);
}

TEST_CASE("A tool force that is not a number freezes though no flag is set", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(16);
  StepReport report;
  report.tool_force.y() = std::numeric_limits<double>::quiet_NaN();
  CHECK(watchdog.judge(report, 5, log));
}

TEST_CASE("A blow-up freezes at once and says how far the node went", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(16);
  StepReport report;
  report.flags = kBlowUp;
  report.worst_node = 3;
  report.max_increment = 0.25F;
  CHECK(watchdog.judge(report, 1, log));
  LogEvent event;
  REQUIRE(log.pop(event));
  CHECK(event.kind == LogEvent::Kind::FrozenBlowUp);
  CHECK(event.value == 0.25);
  CHECK(logText(event).find("moved 250 mm in one step") != std::string::npos);
}

TEST_CASE("A few inverted points warn once; a lasting flood freezes; a huge one at once", "[watchdog]") {
  const Model model = manyPoints();  // 1000 points: flood 20, at once 200
  const WatchdogLimits limits;
  LogRing log(64);
  LogEvent event;
  {
    Watchdog watchdog(model);
    for (int t = 0; t < 2000; ++t) REQUIRE_FALSE(watchdog.judge(inverted(19), t, log));
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
    log.pop(event);
  }
  {
    Watchdog watchdog(model);
    for (int t = 0; t < limits.flood_ticks - 1; ++t) REQUIRE_FALSE(watchdog.judge(inverted(20), t, log));
    REQUIRE_FALSE(watchdog.judge(inverted(0), 100, log));  // recovers: counts from the beginning
    for (int t = 0; t < limits.flood_ticks - 1; ++t) REQUIRE_FALSE(watchdog.judge(inverted(20), 200 + t, log));
    CHECK(watchdog.judge(inverted(20), 300, log));
    while (log.size() > 0) log.pop(event);
    CHECK(event.kind == LogEvent::Kind::FrozenInverted);
    CHECK(event.value == 20);
  }
  {
    Watchdog watchdog(model);
    CHECK_FALSE(watchdog.judge(inverted(199), 0, log));
    CHECK(watchdog.judge(inverted(200), 1, log));
  }
}

TEST_CASE("A full log does not keep the watchdog from freezing", "[watchdog]") {
  const Model model = manyPoints();
  Watchdog watchdog(model);
  LogRing log(1);
  log.push({});
  StepReport report;
  report.flags = kNotFinite;
  CHECK(watchdog.judge(report, 0, log));
}
