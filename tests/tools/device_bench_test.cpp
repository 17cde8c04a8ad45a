// Simulated haptic devices: a short part of what `mtled bench --device` runs, in simulated time.

#include "mtled/bench/device_bench.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>

#include "scene/device_settings.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

TEST_CASE("The spectrum's peak above a frequency is found, with its amplitude", "[device]") {
  std::vector<Vec3> force;
  for (int k = 0; k < 1000; ++k) {
    const double t = 2 * std::numbers::pi * k / 1000;
    force.emplace_back(0, 0, 3 + 2 * std::sin(5 * t) + 0.1 * std::sin(50 * t) + 0.05 * std::cos(90 * t));
  }
  const auto [amplitude, hz] = spectralPeak(force, 1000, 20);
  CHECK(hz == Approx(50));
  CHECK(amplitude == Approx(0.1).epsilon(1e-6));
}

TEST_CASE("A row names the bounds that it misses", "[device]") {
  DeviceResult good;
  good.peak_force = 1;
  CHECK(missedBounds(good).empty());
  DeviceResult bad = good;
  bad.limit_cycle = 0.02;
  bad.static_error = 0.03;
  bad.silence_ms = 61;
  CHECK(missedBounds(bad) == "limit cycle, static force, silence");
  std::ostringstream out;
  printDeviceRows(out, {{"gel", {}, bad}});
  CHECK_THAT(out.str(), Contains("gel") && Contains("light") && Contains("limit cycle, static force, silence"));
}

TEST_CASE("A light hand on a hard inclusion feels it without a buzz, and a silent device lets go", "[device][whole]") {
  Model model = deviceBody("inclusion");
  DeviceTrial trial;
  trial.delay_s = 0.005;
  trial.seconds = 6.1;
  const DeviceResult result = runDeviceTrial(model, trial);
  CAPTURE(missedBounds(result), result.limit_cycle, result.static_error, result.silence_ms, result.latency_ticks);
  CHECK(missedBounds(result).empty());
  CHECK(result.silence_ms > 0);
  CHECK(result.felt_stiffness >
        0.5 * result.tissue_stiffness / (1 + result.tissue_stiffness / result.coupling_stiffness));
}

TEST_CASE("A trial with a device depends on nothing but its settings", "[device][whole]") {
  const Model model = deviceBody("gel");
  DeviceTrial trial;
  trial.firm = true;
  trial.delay_s = 0.002;
  trial.seconds = 0.8;
  const DeviceResult once = runDeviceTrial(model, trial), again = runDeviceTrial(model, trial);
  CHECK(once.peak_force > 0);
  CHECK(once.peak_force == again.peak_force);
  CHECK(once.lowest_energy_J == again.lowest_energy_J);
  ++trial.seed;
  CHECK(runDeviceTrial(model, trial).peak_force != once.peak_force);
}

TEST_CASE("A loose hand behind a delay gets no energy from a slab, rocked or not", "[device][whole]") {
  const Model model = deviceBody("slab");
  DeviceTrial trial;
  SimulatedDeviceSettings device;
  device.mass = 0.08;
  device.damping = device.friction = 0;
  device.encoder_step = 1e-6;
  device.delay_s = 0.012;  // 5 ms each way, 1 ms of jitter
  device.least_delay_s = 0.010;
  trial.device = device;
  trial.hand = HandModel::loose();
  trial.deeper = 0.06;  // m, to which 5 N/m push with 0.3 N
  trial.rock = GENERATE(0.0, 0.25);
  trial.seconds = 5;
  const DeviceResult result = runDeviceTrial(model, trial);
  CHECK(result.given_J < 1e-4);
  CHECK(result.pull < 0.01);
  CHECK(result.static_error < 0.03);
  CHECK((trial.rock > 0) == (result.peak_torque > 3e-4));
}
