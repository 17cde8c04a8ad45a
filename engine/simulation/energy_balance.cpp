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
  return (std::abs(drift) + alternating) / scale;
}

}  // namespace palpate
