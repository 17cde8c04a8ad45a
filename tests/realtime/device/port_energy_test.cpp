#include "realtime/device/port_energy.h"

#include <catch2/catch.hpp>

using namespace palpate;

namespace {

constexpr std::int64_t ms = 1'000'000;

/// The force of each millisecond, and a handle that has the one of `late` ms before and goes up by `way` in each.
struct Line {
  void go(int calls, double force, int late, bool tells, double way = 1e-4) {
    for (int k = 0; k < calls; ++k) {
      ++sequence;
      const auto ago = static_cast<std::uint32_t>(late + 1);
      const std::uint32_t felt = sequence > ago ? sequence - ago : 0;
      energy.moved(sequence * ms, tells ? felt : 0, {way * Vec3::UnitZ(), Vec3::Zero()}, 1e-3, false);
      energy.sent(sequence, sequence * ms, {force * Vec3::UnitZ(), Vec3::Zero()});
    }
  }
  PortEnergy energy;
  std::uint32_t sequence = 0;
};

}  // namespace

TEST_CASE("Energy is counted with the force that the motors had, as the device tells it", "[device]") {
  Line line;
  line.go(20, 0, 10, true);
  line.go(10, 1, 10, true);  // the motors have had none of these
  CHECK(line.energy.pushed() == Approx(0).margin(1e-12));
  CHECK(line.energy.delay() == Approx(0.010).epsilon(0.02));
  line.go(10, 0, 10, true);
  line.go(20, 0, 10, true);
  // Ten ways of 0.1 mm against 1 N; the one in which the force came counts as if it had been there from its begin.
  CHECK(line.energy.pushed() == Approx(-1.1e-3).epsilon(0.01));
  CHECK(line.energy.underway(line.sequence * ms, {Vec3::UnitZ(), Vec3::Zero()}, true) == Approx(0).margin(1e-12));
}

TEST_CASE("Where no delay is told, the one is believed by which the hand has paid least", "[device]") {
  const bool at_once = GENERATE(true, false);
  Line line;
  line.go(60, 0, 0, false, 0);
  line.go(20, 1, 0, false, at_once ? 1e-4 : 0);
  line.go(20, 0, 0, false, at_once ? 0 : 1e-4);  // by a delay of 20 ms this was with the force
  line.go(60, 0, 0, false, 0);
  CHECK(line.energy.pushed() == Approx(-2e-3).epsilon(0.15));
  CHECK(line.energy.all() == Approx(line.energy.pushed()));
  CHECK(line.energy.delay() >= (at_once ? PortEnergy::assumed_s : 0.016));  // it is shown
}

TEST_CASE("What went on while poses were missing pays for nothing", "[device]") {
  Line line;
  line.go(20, -1, 0, true);
  const double before = line.energy.pushed();
  line.energy.moved(line.sequence * ms, line.sequence, {0.01 * Vec3::UnitZ(), Vec3::Zero()}, 0.05, true);
  CHECK(line.energy.pushed() == Approx(before));
  line.energy.moved(line.sequence * ms, line.sequence, {-0.01 * Vec3::UnitZ(), Vec3::Zero()}, 0.05, true);
  CHECK(line.energy.pushed() == Approx(before - 0.01));
}

TEST_CASE("Torques pay for torques, not for forces", "[device]") {
  PortEnergy energy;
  AlongAndTurning force, way;
  force.turning = -Vec3::UnitX();
  way.turning = 1e-3 * Vec3::UnitX();
  for (std::uint32_t k = 1; k < 50; ++k) {
    energy.moved(k * ms, k - 1, way, 1e-3, false);
    energy.sent(k, k * ms, force);
  }
  CHECK(energy.pushed() == 0);
  CHECK(energy.all() > 0.04);
  energy.forget();
  CHECK(energy.all() == 0);
}
