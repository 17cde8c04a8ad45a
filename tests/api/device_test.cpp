#include <time.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <thread>

#include "api/palpate_device.h"
#include "api/pressed_block.h"
#include "support/realtime_guard.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// A handle that goes down from where it took the tool, and what it is pushed with.
struct Handle {
  explicit Handle(palpate_simulation* of) : simulation(of) { std::copy_n(straight, 4, pose.pose + 3); }

  /// One exchange. @param depth  m below the start
  std::int32_t exchange(double depth) {
    const double before = force();
    const std::int64_t before_ns = now_ns;
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    now_ns = 1'000'000'000LL * now.tv_sec + now.tv_nsec;
    pose.pose[2] = -depth;
    pose.felt = wrench.sequence;
    ++pose.sequence;
    const std::int32_t code = palpate_exchange(simulation, now_ns, &pose, &wrench);
    if (before_ns > 0)
      fastest_rise = std::max(fastest_rise, (force() - before) / (1e-9 * static_cast<double>(now_ns - before_ns)));
    largest = std::max(largest, force());
    return code;
  }
  double force() const { return std::hypot(wrench.force[0], wrench.force[1], wrench.force[2]); }

  static constexpr double straight[4] = {0, 0, 0, 1};
  palpate_simulation* simulation;
  palpate_device_pose pose = sized<palpate_device_pose>();
  palpate_wrench wrench = sized<palpate_wrench>();
  std::int64_t now_ns = 0;
  double largest = 0, fastest_rise = 0;  // N, N/s
};

palpate_coupling_state couplingOf(palpate_simulation* simulation) {
  auto state = sized<palpate_coupling_state>();
  REQUIRE(palpate_read_coupling(simulation, &state) == PALPATE_OK);
  return state;
}

void wait() { std::this_thread::sleep_for(std::chrono::microseconds(900)); }

}  // namespace

TEST_CASE("Exchanges beside a running loop are counted, each with a wrench that answers", "[api][device]") {
  const ModelHandle model = loadBlock();
  const SimulationHandle handle = create(model);
  REQUIRE(palpate_couple(handle.get(), nullptr, nullptr) == PALPATE_OK);
  REQUIRE(palpate_start(handle.get(), PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  Handle hand(handle.get());
  for (int k = 1; k <= 200; ++k) {
    CHECK(hand.exchange(1e-5 * k) == PALPATE_OK);
    CHECK(hand.wrench.answers == static_cast<std::uint32_t>(k));
    wait();
  }
  CHECK(couplingOf(handle.get()).poses == 200);
  REQUIRE(palpate_stop(handle.get()) == PALPATE_OK);
}

// [whole]: under sanitizers the loop is too slow for its forces to be fresh, and the coupling fades as it should.
TEST_CASE("A device presses the tool into the tissue, and is pushed back within its bounds", "[api][device][whole]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle handle = create(model);
  palpate_simulation* const simulation = handle.get();
  auto settings = sized<palpate_device_settings>();
  REQUIRE(palpate_scene_device(model.get(), &settings) == PALPATE_OK);
  CHECK(settings.stiffness == 400);
  CHECK(settings.max_force == 3.3);
  settings.max_force = 0.4;
  REQUIRE(palpate_couple(simulation, &settings, nullptr) == PALPATE_OK);
  REQUIRE(palpate_start(simulation, PALPATE_ORDINARY_THREAD) == PALPATE_OK);

  Handle hand(simulation);
  auto state = sized<palpate_state>();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  double depth = 0;
  // Until both are sure of each other; a busy machine may let the coupling fade meanwhile.
  while (hand.force() < 0.1 && std::chrono::steady_clock::now() < deadline) {
    depth = std::min(depth + 2e-5, info.first_contact_travel + 0.012);
    REQUIRE(hand.exchange(depth) == PALPATE_OK);
    REQUIRE(palpate_read(simulation, &state) == PALPATE_OK);
    wait();
  }
  CHECK(hand.force() >= 0.1);
  CHECK(hand.wrench.touching == 1);
  CHECK(hand.wrench.force[2] > 0.9 * hand.force());
  CHECK(state.force[2] > 0);
  CHECK(state.pose_sequence > 0);
  CHECK(hand.largest <= 0.4 * (1 + 1e-9));
  CHECK(hand.fastest_rise <= 0.4 / 0.01 * (1 + 1e-6));
  const palpate_coupling_state seen = couplingOf(simulation);
  CHECK(seen.poses > 100);
  CHECK(seen.peak_force == Approx(hand.largest));
  CHECK(seen.energy_J > 0);             // the hand has pressed,
  CHECK(seen.lowest_energy_J > -1e-3);  // and was given next to nothing

  // A pose that is none is as good as silence, and the dead man's bounds hold.
  hand.pose.pose[0] = std::nan("");
  for (int k = 0; k < 100; ++k) {
    CHECK(hand.exchange(depth) == PALPATE_BAD_ARGUMENT);
    wait();
  }
  CHECK(hand.force() == 0);
  CHECK(couplingOf(simulation).engaged == 0);
  CHECK(couplingOf(simulation).silences + couplingOf(simulation).fades > 0);
  REQUIRE(palpate_stop(simulation) == PALPATE_OK);
}

TEST_CASE("While a device has the tool nobody else moves it, and uncoupled it is a hand's again", "[api][device]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle handle = create(model), untouched = create(model);
  palpate_simulation* const simulation = handle.get();
  const auto pose = poseAtDepth(info, 0.001);
  auto wrench = sized<palpate_wrench>();
  auto report = sized<palpate_coupling_state>();
  CHECK(palpate_exchange(simulation, 0, nullptr, &wrench) == PALPATE_REFUSED);
  CHECK(palpate_read_coupling(simulation, &report) == PALPATE_REFUSED);
  REQUIRE(palpate_uncouple(simulation) == PALPATE_OK);

  REQUIRE(palpate_couple(simulation, nullptr, nullptr) == PALPATE_OK);
  const std::uint64_t before = hashOf(handle);
  CHECK(palpate_set_target(simulation, pose.data(), 1) == PALPATE_REFUSED);
  CHECK(palpate_set_tool_target(simulation, 0, pose.data(), 1) == PALPATE_REFUSED);
  CHECK(palpate_step(simulation, 1, pose.data(), nullptr) == PALPATE_REFUSED);
  palpate_simulation* one[] = {simulation};
  CHECK(palpate_step_many(nullptr, one, 1, 1, pose.data(), nullptr, nullptr) == PALPATE_REFUSED);
  CHECK(hashOf(handle) == before);
  REQUIRE(palpate_step(simulation, 5, nullptr, nullptr) == PALPATE_OK);  // without a device the tool stays
  REQUIRE(palpate_uncouple(simulation) == PALPATE_OK);
  REQUIRE(palpate_step(untouched.get(), 5, nullptr, nullptr) == PALPATE_OK);
  CHECK(hashOf(handle) == hashOf(untouched));
  auto a = sized<palpate_state>(), b = sized<palpate_state>();
  REQUIRE(palpate_step(simulation, 30, pose.data(), &a) == PALPATE_OK);
  REQUIRE(palpate_step(untouched.get(), 30, pose.data(), &b) == PALPATE_OK);
  CHECK(a.force[2] > 0);
  CHECK(hashOf(handle) == hashOf(untouched));
}

TEST_CASE("A coupling that can't be meant is refused, and leaves the one that is", "[api][device]") {
  const ModelHandle model = loadBlock();
  const SimulationHandle handle = create(model);
  palpate_simulation* const simulation = handle.get();
  const std::uint64_t before = hashOf(handle);
  auto error = sized<palpate_error>();
  auto settings = sized<palpate_device_settings>();
  const auto refused = [&](double palpate_device_settings::*member, double value, const char* text) {
    REQUIRE(palpate_scene_device(model.get(), &settings) == PALPATE_OK);
    settings.*member = value;
    CHECK(palpate_couple(simulation, &settings, &error) == PALPATE_BAD_ARGUMENT);
    CHECK_THAT(error.text, Catch::Contains(text));
  };
  refused(&palpate_device_settings::stiffness, 1, "\"stiffness\" must be 10 .. 20000");
  refused(&palpate_device_settings::damping, -1, "\"damping\" must be");
  refused(&palpate_device_settings::max_force, 0, "\"max_force\" must be");
  refused(&palpate_device_settings::rise_time, 0, "\"rise_time\" must be");
  refused(&palpate_device_settings::scale, std::nan(""), "\"scale\" must be");
  refused(&palpate_device_settings::own_damping, 1e3, "\"own_damping\" must be");
  refused(&palpate_device_settings::lever, 0, "\"lever\" must be");
  settings = {};
  CHECK(palpate_couple(simulation, &settings, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_couple(nullptr, nullptr, &error) == PALPATE_BAD_ARGUMENT);
  auto wrench = sized<palpate_wrench>();
  CHECK(palpate_exchange(simulation, 0, nullptr, &wrench) == PALPATE_REFUSED);  // none of these has coupled it

  REQUIRE(palpate_couple(simulation, nullptr, nullptr) == PALPATE_OK);
  auto pose = sized<palpate_device_pose>();
  CHECK(palpate_exchange(simulation, 0, nullptr, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_exchange(simulation, -1, nullptr, &wrench) == PALPATE_BAD_ARGUMENT);
  pose.size = 0;
  CHECK(palpate_exchange(simulation, 0, &pose, &wrench) == PALPATE_BAD_ARGUMENT);
  wrench.size = 0;
  CHECK(palpate_exchange(simulation, 0, nullptr, &wrench) == PALPATE_BAD_ARGUMENT);
  CHECK(hashOf(handle) == before);
  REQUIRE(palpate_start(simulation, PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  CHECK(palpate_couple(simulation, nullptr, &error) == PALPATE_BUSY);
  CHECK(palpate_uncouple(simulation) == PALPATE_BUSY);
  REQUIRE(palpate_stop(simulation) == PALPATE_OK);
}

TEST_CASE("An exchange with the device takes no lock and allocates nothing", "[api][device]") {
  if (!guardAvailable()) return;
  const ModelHandle model = loadBlock();
  const SimulationHandle simulation = create(model);
  REQUIRE(palpate_couple(simulation.get(), nullptr, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 3, nullptr, nullptr) == PALPATE_OK);
  Handle hand(simulation.get());
  std::int32_t code = 0;
  auto report = sized<palpate_coupling_state>();
  startGuard();
  for (int k = 0; k < 20; ++k) {
    code |= hand.exchange(0.001 * k);
    code |= palpate_step(simulation.get(), 1, nullptr, nullptr);
  }
  code |= palpate_read_coupling(simulation.get(), &report);
  const GuardCounts counts = stopGuard();
  CHECK(code == PALPATE_OK);
  CHECK(counts.total() == 0);
  CHECK(report.poses == 20);
}
