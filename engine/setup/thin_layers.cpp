#include "setup/thin_layers.h"

#include <algorithm>
#include <cmath>

#include "scene/scene_regions.h"

namespace palpate {
namespace {

/// Places in a cell, each of the same share of it.
constexpr std::array<std::array<double, 4>, 11> samples{{{.25, .25, .25, .25},
                                                         {.7, .1, .1, .1},
                                                         {.1, .7, .1, .1},
                                                         {.1, .1, .7, .1},
                                                         {.1, .1, .1, .7},
                                                         {.4, .4, .1, .1},
                                                         {.4, .1, .4, .1},
                                                         {.4, .1, .1, .4},
                                                         {.1, .4, .4, .1},
                                                         {.1, .4, .1, .4},
                                                         {.1, .1, .4, .4}}};
constexpr double seen = 0.25;  // missed share, up to which a material counts as seen

}  // namespace

ThinLayer thinnestLayer(const Scene& scene, const SurfaceTree& organ, const std::vector<Vec3>& X,
                        const std::vector<std::array<int, 4>>& cells, const std::vector<int>& cell_material) {
  const std::size_t count = scene.materials.size();
  const bool mixes = std::any_of(scene.materials.begin(), scene.materials.end(),
                                 [](const MaterialSpec& m) { return m.membership != nullptr; });
  if (count < 2 || mixes) return {};
  std::vector<int> of_node;
  for (const Vec3& x : X) of_node.push_back(materialAt(scene, x, organ));
  std::vector<double> volume(count), missed(count), unlike(count);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& [i, j, k, l] = cells[c];
    const auto own = static_cast<std::size_t>(cell_material[c]);
    const double whole = std::abs((X[j] - X[i]).cross(X[k] - X[i]).dot(X[l] - X[i])) / 6;
    if (std::all_of(cells[c].begin(), cells[c].end(), [&](int n) { return of_node[n] == cell_material[c]; })) {
      volume[own] += whole;
      continue;
    }
    for (const auto& share : samples) {
      const Vec3 x = share[0] * X[i] + share[1] * X[j] + share[2] * X[k] + share[3] * X[l];
      const auto there = static_cast<std::size_t>(materialAt(scene, x, organ));
      const double part = whole / static_cast<double>(samples.size());
      volume[there] += part;
      if (there == own) continue;
      const auto [softer, stiffer] =
          std::minmax(scene.materials[there].material.shear_modulus, scene.materials[own].material.shear_modulus);
      missed[there] += part;
      unlike[there] += part * (1 - softer / stiffer);
    }
  }
  ThinLayer worst;
  for (std::size_t m = 0; m < count; ++m)
    if (missed[m] > seen * volume[m] && unlike[m] > 2 * worst.error * volume[m])
      worst = {static_cast<int>(m), unlike[m] / (2 * volume[m])};
  return worst;
}

}  // namespace palpate
