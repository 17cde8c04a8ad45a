#include "app/run/soak_report.h"

#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include <sys/syscall.h>
#include <unistd.h>

#include "model/state.h"

using namespace palpate;
using namespace palpate::app;
using nlohmann::json;

namespace {

SoakReport goodReport() {
  SoakReport report;
  report.scene = "block";
  report.state = "done";
  report.minutes = 5;
  report.physics_seconds = 300;
  report.organ_size_m = 0.2;
  report.cycles = 100;
  report.drift_m = 1e-9;
  report.warm = MemoryUse{3'000'000, 2'000'000};
  report.memory = {3'500'000, 2'000'000};  // more files mapped is no leak
  report.threads = {{4711, {1, 2, 3, 4}}};
  return report;
}

}  // namespace

TEST_CASE("Each broken promise of a soak is named, and a good run breaks none", "[soak_report]") {
  CHECK(brokenPromises(goodReport()).empty());
  const auto only = [](const SoakReport& report, const char* named) {
    const std::vector<std::string> broken = brokenPromises(report);
    REQUIRE(broken.size() == 1);
    CHECK(broken[0].find(named) != std::string::npos);
    CHECK(toText(report).find("BROKEN: " + broken[0]) != std::string::npos);
    CHECK(json::parse(toJson(report))["broken_promises"] == json(broken));
  };
  SoakReport report = goodReport();
  report.memory.anonymous += 4096;
  only(report, "memory grew by 4 kB");
  report = goodReport();
  report.drift_m = 2.1e-7;  // of 0.2 m: above 1e-6
  only(report, "drifted");
  report.drift_m = 1.9e-7;
  CHECK(brokenPromises(report).empty());
  report.drift_m = std::numeric_limits<double>::quiet_NaN();
  only(report, "finite");
  for (const std::uint32_t flag : {kNotFinite, kBlowUp}) {
    report = goodReport();
    report.flags = flag;
    only(report, "finite");
  }
  report = goodReport();
  report.unrested_cycles = 1;
  report.unrested_speed = 2e-3;
  only(report, "by up to 2.0e-03 m/s");
  report = goodReport();
  report.cycles = 0;
  only(report, "no cycle came to its end");
}

TEST_CASE("A rough hand may not put the tissue back more often than was measured, whatever it is lost to",
          "[soak_report]") {
  struct Limit {
    std::int64_t Restores::*count;
    double limit;
    const char* named;
  };
  for (const Limit& one :
       {Limit{&Restores::lost, RoughLimits::lost, "was lost"}, Limit{&Restores::folded, RoughLimits::folded, "folded"}})
    for (const std::int64_t ticks : {std::int64_t{1000}, std::int64_t{2'000'000}}) {
      SoakReport report = goodReport();
      report.rough = true;
      report.ticks = ticks;
      report.flags = kBlowUp;  // a loss is counted, not told by its flag
      report.restores.*one.count = report.restored =
          1 + static_cast<std::int64_t>(1e-6 * one.limit * static_cast<double>(ticks));
      CHECK(brokenPromises(report).empty());
      ++(report.restores.*one.count);
      REQUIRE(brokenPromises(report).size() == 1);
      CHECK(brokenPromises(report)[0].find(one.named) != std::string::npos);
    }
  SoakReport report = goodReport();
  report.rough = true;
  report.ticks = 1'000'000;
  report.let_go = 1 + static_cast<std::int64_t>(1e-6 * RoughLimits::let_go * 1e6);
  CHECK(brokenPromises(report).empty());
  ++report.let_go;
  REQUIRE(brokenPromises(report).size() == 1);
  CHECK(brokenPromises(report)[0].find("was stuck and let go") != std::string::npos);
  report.let_go = 0;
  report.crossings = RoughLimits::crossings;
  CHECK(brokenPromises(report).empty());
  ++report.crossings;
  CHECK(brokenPromises(report).size() == 1);
  report.crossings = report.crossings_at_rest = 1;
  REQUIRE(brokenPromises(report).size() == 1);
  CHECK(brokenPromises(report)[0] == "at rest the skin crosses itself at 1 places");
}

TEST_CASE("A soak's report has what was measured, as JSON and as text", "[soak_report]") {
  SoakReport report = goodReport();
  SoakCycle cycle;
  cycle.rested = true;
  cycle.rest_s = 1.5;
  cycle.peak_force_N = 0.7;
  cycle.min_J = 0.6F;
  cycle.flags = kDeepContact;
  cycle.drift_m = 3e-9;
  addCycle(report, cycle);
  cycle.drift_m = 2e-9;
  cycle.rested = false;
  cycle.rest_speed = 4e-4;
  addCycle(report, cycle);
  CHECK(report.cycles == 102);
  CHECK(report.unrested_cycles == 1);
  CHECK(report.unrested_speed == 4e-4);
  CHECK(report.drift_m == 2e-9);
  CHECK(report.largest_drift_m == 3e-9);

  const auto steps = std::make_unique<DurationHistogram>();
  for (int k = 0; k < 1000; ++k) steps->add(500'000);
  steps->add(12'000'000);
  report.step_bars = barsOf(*steps);
  report.step_us = steps->percentiles();
  report.late_ticks = {4, 3, 2, 1};
  const json j = json::parse(toJson(report));
  CHECK(j["cycles"] == 102);
  CHECK(j["drift"] == Approx(1e-8));
  CHECK(j["min_J"] == Approx(0.6));
  CHECK(j["flags"] == json({"deep_contact"}));
  CHECK(j["late_ticks"]["core_taken"] == 3);
  CHECK(j["memory_growth"] == 0);
  CHECK(j["threads_since_warm_up"][0]["major_faults"] == 2);
  CHECK(j["step_us"]["max"] == 12'000.0);
  std::int64_t counted = 0;
  for (const auto& bar : j["step_histogram"]) {
    CHECK(bar[0] < bar[1]);
    counted += bar[2].get<std::int64_t>();
  }
  CHECK(counted == 1001);
  CHECK(j["step_histogram"].front()[0] <= 500.0);
  CHECK(j["step_histogram"].front()[1] > 500.0);
  CHECK(j["step_histogram"].back()[1] > 12'000.0);
  const std::string text = toText(report);
  for (const char* part : {"102 cycles", "4 woken late", "deep_contact", "thread 4711", "1 minor and 2 major", "+0 kB"})
    CHECK(text.find(part) != std::string::npos);
  report.warm.reset();
  CHECK(json::parse(toJson(report))["memory_growth"].is_null());
  CHECK(soakLine(report).find("still warming up") != std::string::npos);
}

TEST_CASE("A thread's faults and switches and the process's memory are seen", "[soak_report]") {
  constexpr std::size_t size = 16 << 20;
  const MemoryUse before = readMemoryUse();
  std::vector<char> block;
  ThreadCounters gone;
  std::thread([&] {
    const int id = static_cast<int>(syscall(SYS_gettid));
    const ThreadCounters start = readThreadCounters(id);
    block.assign(size, 1);  // touches each page
    for (int k = 0; k < 20; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    gone = readThreadCounters(id) - start;
  }).join();
  const MemoryUse after = readMemoryUse();
  CHECK(gone.minor_faults + gone.major_faults > 0);  // large pages make few of them
  CHECK(gone.voluntary_switches >= 20);
  CHECK(after.anonymous - before.anonymous > static_cast<std::int64_t>(size) * 9 / 10);
  CHECK(after.resident >= after.anonymous);
  CHECK(readThreadCounters(0).voluntary_switches == 0);
}
