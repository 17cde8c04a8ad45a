#include "model/energy_balance.h"

#include <algorithm>
#include <cmath>

namespace palpate {

void EnergyBalance::relax(double energy, double power, double dt) {
  relaxation_flow += 0.5 * dt * (relaxation_power + power);
  relaxation_power = power;
  relaxed = energy - relaxation_flow;
}

double EnergyBalance::update(double strain, double kinetic, double acceleration_energy, double dt, double floor) {
  constexpr double memory = 0.25;  // s
  const double kept = std::exp(-dt / memory), now = strain - relaxed - work;
  drift = drift * kept + (fresh ? 0 : now - mismatch);
  mismatch = now;
  fresh = false;
  scale = std::max({scale * kept, strain + kinetic, floor});
  acceleration_shares[static_cast<std::size_t>(next_share)] = acceleration_energy / scale;
  next_share = (next_share + 1) % static_cast<int>(acceleration_shares.size());
  return std::abs(drift) / scale + *std::min_element(acceleration_shares.begin(), acceleration_shares.end());
}

}  // namespace palpate
