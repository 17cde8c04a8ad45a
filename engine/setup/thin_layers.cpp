#include "setup/thin_layers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "imaging/membership.h"
#include "scene/scene_regions.h"
#include "setup/mixtures.h"

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
/// Of the body, that a material has at least to count: what is smaller is felt nowhere but beside it.
constexpr double least_share = 0.002;

double sizeOf(const std::vector<Vec3>& X, const std::array<int, 4>& cell) {
  const auto& [i, j, k, l] = cell;
  return std::abs((X[j] - X[i]).cross(X[k] - X[i]).dot(X[l] - X[i])) / 6;
}

/// What the cells have of each material, and miss of it.
class Shares {
 public:
  Shares(const Scene& scene, const SurfaceTree& organ, const std::vector<Vec3>& X)
      : scene_(scene), organ_(organ), X_(X), volume(scene.materials.size()), taken(volume.size(), volume) {}

  /// By the materials at places in a cell that is taken for `own`.
  void sample(const std::array<int, 4>& cell, std::size_t own) {
    const auto& [i, j, k, l] = cell;
    const double part = sizeOf(X_, cell) / static_cast<double>(samples.size());
    for (const auto& share : samples) {
      const Vec3 x = share[0] * X_[i] + share[1] * X_[j] + share[2] * X_[k] + share[3] * X_[l];
      const auto there = static_cast<std::size_t>(materialAt(scene_, x, organ_));
      volume[there] += part;
      if (there != own) taken[there][own] += part;
    }
  }

 private:
  const Scene& scene_;
  const SurfaceTree& organ_;
  const std::vector<Vec3>& X_;

 public:
  std::vector<double> volume;              // (material_count) m^3
  std::vector<std::vector<double>> taken;  // (material_count, material_count) m^3 of the first, for the second
};

ThinLayer mixedLayer(const Scene& scene, int mixed, const std::vector<Vec3>& X,
                     const std::vector<std::array<int, 4>>& cells, const std::vector<int>& cell_material) {
  constexpr double told = 0.05;  // error from which on it is: what trusted forces have
  // Displacements are as smooth as supports are wide, not cells: columns and balls over layers are 1.4 to 2.9 times as
  // far off as their cells are.
  constexpr double of_supports = 2;
  const auto& materials = scene.materials;
  const MaterialSpec& other = materials[static_cast<std::size_t>(mixed)];
  const auto modulus = [&](double share) {
    return mixedModulus(scene, materials[0].material.shear_modulus, other.material.shear_modulus, share);
  };
  double by_image = 0, by_cells = 0;  // compliance times volume
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& [i, j, k, l] = cells[c];
    const double size = sizeOf(X, cells[c]);
    double sum = 0, compliance = 0, known = 0;
    for (std::size_t s = 0; cell_material[c] == 0 && s < samples.size(); ++s) {
      const auto& at = samples[s];
      const auto share = shareAt(*other.membership, at[0] * X[i] + at[1] * X[j] + at[2] * X[k] + at[3] * X[l]);
      if (share) sum += *share, compliance += 1 / modulus(*share), ++known;
    }
    const double mean =
        known > 0 ? modulus(sum / known) : materials[static_cast<std::size_t>(cell_material[c])].material.shear_modulus;
    by_cells += size / mean;
    by_image += size * (known > 0 ? compliance / known : 1 / mean);
  }
  const double error = by_cells > 0 ? of_supports * std::max(0.0, by_image / by_cells - 1) : 0;
  return {error > told ? mixed : -1, error};
}

}  // namespace

ThinLayer thinnestLayer(const Scene& scene, const SurfaceTree& organ, const std::vector<Vec3>& X,
                        const std::vector<std::array<int, 4>>& cells, const std::vector<int>& cell_material) {
  const std::size_t count = scene.materials.size();
  if (count < 2) return {};
  if (const int mixed = mixedMaterial(scene); mixed > 0) {
    const bool measured = std::any_of(scene.boundaries.begin(), scene.boundaries.end(),
                                      [](const BoundarySpec& b) { return b.region.kind == Region::Kind::Point; });
    return measured ? ThinLayer{} : mixedLayer(scene, mixed, X, cells, cell_material);
  }
  std::vector<int> of_node;
  for (const Vec3& x : X) of_node.push_back(materialAt(scene, x, organ));
  // What has no node may lie within cells; but a shell, whose depth takes long to find, has all nodes on the surface.
  const bool has_shell = std::any_of(scene.materials.begin(), scene.materials.end(), [](const MaterialSpec& m) {
    return !m.everywhere && m.region.kind == Region::Kind::Shell;
  });
  Shares shares(scene, organ, X);
  double whole = 0;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto own = static_cast<std::size_t>(cell_material[c]);
    const double size = sizeOf(X, cells[c]);
    whole += size;
    if (has_shell &&
        std::all_of(cells[c].begin(), cells[c].end(), [&](int n) { return of_node[n] == cell_material[c]; }))
      shares.volume[own] += size;
    else
      shares.sample(cells[c], own);
  }
  ThinLayer worst;
  Preparation known;
  const std::vector<Material> materials = materialsOf(scene);
  for (std::size_t m = 0; m < count; ++m) {
    const double volume = shares.volume[m];
    const std::vector<double>& taken = shares.taken[m];
    if (volume < least_share * whole || !(std::accumulate(taken.begin(), taken.end(), 0.0) > seen * volume)) continue;
    for (std::size_t o = 0; o < count; ++o)
      if (taken[o] > 0)
        known.missed_shares.push_back({0, static_cast<int>(m), static_cast<int>(o), 0, taken[o] / volume});
    const double before = worst.error;
    worst.error = layerError(known, materials);
    if (worst.error > before) worst.material = static_cast<int>(m);
  }
  worst.missed = std::move(known.missed_shares);
  return worst;
}

}  // namespace palpate
