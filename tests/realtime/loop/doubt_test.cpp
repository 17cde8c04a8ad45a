#include <catch2/catch.hpp>

#include "realtime/channels/log_event.h"
#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/recording/run_report.h"
#include "step/trust.h"

using namespace palpate;
using namespace palpate::test;

TEST_CASE("A doubt goes with the force, into the log once, and into the report with its time",
          "[simulation_loop][trust]") {
  const Model model = smallModel(500);
  FakePhysics physics(model);
  physics.on_tick = [](State& state, StepReport& report) {
    if (state.tick > 100 && state.tick <= 150) report.step_share = 1.2;
    if (state.tick > 120 && state.tick <= 130) report.energy_error = 0.5;
  };
  SimulationLoopOptions options;
  options.tick_limit = 200;
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  loop.run(clock);

  ForceSample sample;
  int k = 0;
  while (loop.forces().pop(sample)) {
    ++k;
    const Doubt expected = k > 120 && k <= 130 ? Doubt::Energy : k > 100 && k <= 150 ? Doubt::Step : Doubt::None;
    REQUIRE(sample.doubt == expected);
  }
  CHECK(k == 200);
  CHECK(loop.force().sample.doubt == Doubt::None);

  LogEvent event;
  int doubted = 0;
  while (loop.log().pop(event))
    if (event.kind == LogEvent::Kind::Doubted) {
      ++doubted;
      CHECK(event.isWarning());
      CHECK(event.tick == 100);
      CHECK(logText(event).find(doubtText(Doubt::Step)) != std::string::npos);
    }
  CHECK(doubted == 1);

  const RunReport report = makeRunReport(model, loop.summary(), loop.statistics(), 1, 0);
  CHECK(report.doubt == Doubt::Energy);
  CHECK(report.first_doubt_s == Approx(0.202));  // of its row in force.csv
  CHECK(toJson(report).find("\"trust\": \"energy\"") != std::string::npos);
}

TEST_CASE("A run without doubt says so", "[simulation_loop][trust]") {
  const Model model = smallModel(500);
  FakePhysics physics(model);
  SimulationLoopOptions options;
  options.tick_limit = 20;
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  loop.run(clock);
  const std::string json = toJson(makeRunReport(model, loop.summary(), loop.statistics(), 1, 0));
  CHECK(json.find("\"trust\": \"good\"") != std::string::npos);
  CHECK(json.find("\"first_doubt_s\": null") != std::string::npos);
}
