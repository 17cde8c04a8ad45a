#include "mechanics/mass_scaling.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace palpate {

ScaledMass scaleMass(const ShapeTable& shape, const std::vector<double>& volume, const std::vector<int>& point_material,
                     const std::vector<Material>& materials, const std::vector<double>& mass,
                     const NodePatches& patches, const CriticalTimeStep& limit, double dt) {
  if (limit.dt >= dt) return {mass, limit, 0};
  const auto rows = gershgorinRows(shape, volume, point_material, materials, mass.size());
  const double total = std::accumulate(mass.begin(), mass.end(), 0.0);
  const auto withCap = [&](double cap) {
    ScaledMass scaled{mass, {}, 0};
    for (std::size_t i = 0; i < mass.size(); ++i) {
      scaled.mass[i] = std::max(mass[i], rows[i] / cap);
      scaled.added += (scaled.mass[i] - mass[i]) / total;
    }
    scaled.limit = criticalTimeStep(shape, volume, point_material, materials, scaled.mass, patches);
    return scaled;
  };

  // ln(step / dt) falls from the cap that Gershgorin's theorem proves to be low enough to the one that adds nothing.
  constexpr double tolerance = 5e-3;
  constexpr int max_rounds = 12;
  double low = std::log(4 / (dt * dt)), high = std::log(4 / (limit.dt_proven * limit.dt_proven));
  ScaledMass best = withCap(std::exp(low));
  double above = std::log(best.limit.dt / dt), below = std::log(limit.dt / dt);
  for (int look = 0; look < max_rounds && best.limit.dt > (1 + tolerance) * dt; ++look) {
    // Regula falsi (Illinois), aimed at the middle of the tolerance.
    const double aim = 0.5 * tolerance;
    const double cap = low + (high - low) * std::clamp((above - aim) / (above - below), 0.02, 0.98);
    ScaledMass tried = withCap(std::exp(cap));
    const double value = std::log(tried.limit.dt / dt);
    if (value >= 0) {
      low = cap;
      above = value;
      below = aim + 0.5 * (below - aim);
      best = std::move(tried);
    } else {
      high = cap;
      below = value;
      above = aim + 0.5 * (above - aim);
    }
  }
  return best;
}

}  // namespace palpate
