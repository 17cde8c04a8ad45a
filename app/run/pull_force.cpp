#include "app/run/pull_force.h"

#include <algorithm>

namespace palpate::app {

double pullForce(const Model& model, int vertex, const Vec3& gap) {
  const auto v = static_cast<std::size_t>(vertex);
  double mobility = 0;  // N^T M^-1 N
  for (int e = model.skin.begin[v]; e < model.skin.begin[v + 1]; ++e) {
    const auto k = static_cast<std::size_t>(e);
    const double N = static_cast<double>(model.skin.N[k]);
    mobility += N * N / model.mass[static_cast<std::size_t>(model.skin.node[k])];
  }
  constexpr double share_per_step = 0.02;
  const double c = model.scene.dynamics.damping, h = model.dt, alpha = 2 * h * h / (2 + c * h);
  return share_per_step * std::min(gap.norm(), 2 * model.scene.tools[0].shape.radius) / (mobility * alpha);
}

}  // namespace palpate::app
