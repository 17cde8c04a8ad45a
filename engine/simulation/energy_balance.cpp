#include "simulation/energy_balance.h"

#include <algorithm>
#include <cmath>

namespace palpate {

double EnergyBalance::look(double strain, double kinetic, double alternating, double dt, double floor) {
  constexpr double memory = 0.25;  // s
  const double kept = std::exp(-dt / memory), now = strain - work;
  drift = drift * kept + (fresh ? 0 : now - mismatch);
  mismatch = now;
  fresh = false;
  scale = std::max({scale * kept, strain + kinetic, floor});
  alternating_shares[static_cast<std::size_t>(next_share)] = alternating / scale;
  next_share = (next_share + 1) % static_cast<int>(alternating_shares.size());
  return std::abs(drift) / scale + *std::min_element(alternating_shares.begin(), alternating_shares.end());
}

}  // namespace palpate
