#include "model/energy_balance.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace palpate;

TEST_CASE("A mode beyond the stable step is seen by more than a quarter of its energy in each step", "[trust]") {
  // One mass on one spring, omega = 1: it grows by g a step with (omega dt / 2)^2 = (1 + g)^2 / 4g.
  for (const double g : {1.02, 1.3, 2.0, 4.0}) {
    const double dt = (1 + g) / std::sqrt(g);
    EnergyBalance balance;
    double u = 1, du = -(1 + g) * u, seen = 0;
    for (int k = 0; k < 20; ++k) {
      u += du;
      const double f = -u, next = du + dt * dt * f;
      balance.work -= 0.5 * f * du;
      seen =
          balance.update(0.5 * u * u, 0.5 * next * next / (dt * dt), (next - du) * (next - du) / (8 * dt * dt), dt, 0);
      balance.work -= 0.5 * f * next;
      du = next;
    }
    CAPTURE(g);
    REQUIRE(std::abs(u) == Approx(std::pow(g, 20)).epsilon(1e-6));
    for (const double share : balance.acceleration_shares) CHECK(share == Approx((1 + g) / (4 * g)).epsilon(1e-6));
    CHECK(seen > 0.25);
  }
}

TEST_CASE("What strikes a body sets it moving, and that is no energy of nothing", "[trust]") {
  // A mass is struck to speed 1 in each step: m / 2 of energy, and of Q m / 8 in that step only.
  constexpr double dt = 1e-4, m = 1e-3;
  EnergyBalance balance;
  double worst = 0, kinetic = 0;
  for (int struck = 1; struck <= 10; ++struck) {
    kinetic += m / 2;
    worst = std::max(worst, balance.update(0, kinetic, m / 8, dt, 0));
  }
  CHECK(worst == Approx(1.0 / 16).epsilon(1e-2));  // in the fourth step: a quarter of a quarter of the energy
}
