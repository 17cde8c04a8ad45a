#include "setup/mixtures.h"

#include <algorithm>
#include <cmath>

#include "base/input_error.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "imaging/membership.h"

namespace palpate {
namespace {

/// Shear moduli: tissue of a Poisson's ratio below 0.385 is not averaged at all, of 0.49 to 92 %.
constexpr double mixed_own_bulk = 4;

/// The material of a share, as materialsOf counts them.
int mixtureOf(const Scene& scene, double share) {
  const auto step = static_cast<int>(std::lround(share * mixture_steps));
  if (step == 0) return 0;
  if (step == mixture_steps) return mixedMaterial(scene);
  return static_cast<int>(scene.materials.size()) + step - 1;
}

Material mixed(const Scene& scene, const Material& first, const Material& second, double share) {
  const double mu = mixedModulus(scene, first.shear_modulus, second.shear_modulus, share),
               K = mixedModulus(scene, first.bulk_modulus, second.bulk_modulus, share);
  Material material = first;
  material.set("young", 9 * K * mu / (3 * K + mu));
  material.set("poisson", (3 * K - 2 * mu) / (2 * (3 * K + mu)));
  material.set("density", (1 - share) * first.density + share * second.density);
  return material;
}

/// Throws InputError where a membership's image leaves out more than a tenth of what mixes: it is another body's, or in
/// another unit or frame.
void checkCovers(const MaterialSpec& spec, const std::vector<Vec3>& X, const BackgroundCells& cells,
                 const std::vector<int>& cell_material) {
  constexpr double least = 0.9;
  const ImageGrid& grid = spec.membership->share.grid;
  double covered = 0, whole = 0;
  for (std::size_t c = 0; c < cells.cells.size(); ++c) {
    if (cell_material[c] != 0) continue;
    Vec3 middle = Vec3::Zero();
    for (const int node : cells.cells[c]) middle += 0.25 * X[static_cast<std::size_t>(node)];
    whole += cells.volume[c];
    if (grid.holds(grid.indexOf(middle))) covered += cells.volume[c];
  }
  if (covered < least * whole)
    throw InputError(spec.place,
                     format("the membership's image holds %.0f %% of the organ, and says nothing of the rest",
                            100 * covered / whole),
                     "give an image that the organ lies in (it may be in another unit or frame)");
}

/// Without node patches the kernel multiplies whole stresses, shear and volume alike.
void checkPoisson(const Scene& scene, const MaterialSpec& other) {
  const Material& first = scene.materials[0].material;
  const double ratio = first.bulk_modulus / first.shear_modulus;
  if (scene.discretization.formulation.node_patches ||
      std::abs(other.material.bulk_modulus / other.material.shear_modulus - ratio) < 1e-9 * ratio)
    return;
  throw InputError(other.place, "tissue of unlike Poisson's ratios does not mix in the paper's scheme",
                   "leave scheme = \"paper\" out, or give both the same");
}

}  // namespace

int mixedMaterial(const Scene& scene) {
  for (std::size_t m = 1; m < scene.materials.size(); ++m)
    if (scene.materials[m].membership) return static_cast<int>(m);
  return 0;
}

double mixedModulus(const Scene& scene, double first, double second, double share) {
  return scene.discretization.formulation == Formulation::paper() ? (1 - share) * first + share * second
                                                                  : first * std::pow(second / first, share);
}

double ownBulk(const Scene& scene) {
  const double own = scene.discretization.formulation.own_bulk;
  return mixedMaterial(scene) == 0 ? own : std::max(own, mixed_own_bulk);
}

bool needsPatches(const Scene& scene) {
  return scene.discretization.formulation.node_patches &&
         (mixedMaterial(scene) != 0 ||
          std::any_of(scene.materials.begin(), scene.materials.end(), [&](const MaterialSpec& spec) {
            const Material& m = spec.material;
            return m.bulk_modulus > ownBulk(scene) * m.shear_modulus * m.longTermShare();
          }));
}

std::vector<Material> materialsOf(const Scene& scene) {
  std::vector<Material> materials;
  for (const auto& spec : scene.materials) {
    materials.push_back(spec.material);
    if (!scene.discretization.formulation.floor || spec.material.barrier_strength > 0) continue;
    materials.back().barrier_strength = floor_strength;
    materials.back().barrier_J0 = floor_J0;
  }
  const int other = mixedMaterial(scene);
  if (other != 0) checkPoisson(scene, scene.materials[static_cast<std::size_t>(other)]);
  if (other != 0)
    for (int step = 1; step < mixture_steps; ++step)
      materials.push_back(mixed(scene, materials[0], materials[static_cast<std::size_t>(other)],
                                static_cast<double>(step) / mixture_steps));
  return materials;
}

std::vector<int> mixtureBases(const Scene& scene) {
  const int other = mixedMaterial(scene);
  if (other == 0) return {};
  std::vector<int> base;
  base.reserve(scene.materials.size() + mixture_steps);
  for (int m = 0; m < static_cast<int>(scene.materials.size()); ++m) base.push_back(m == other ? 0 : m);
  base.resize(base.size() + mixture_steps - 1, 0);
  return base;
}

std::vector<double> cellShares(const Scene& scene, const std::vector<Vec3>& X, const BackgroundCells& cells,
                               const std::vector<int>& cell_material) {
  const MaterialSpec& spec = scene.materials[static_cast<std::size_t>(mixedMaterial(scene))];
  const Membership& membership = *spec.membership;
  checkCovers(spec, X, cells, cell_material);
  std::vector<double> share(cells.cells.size());
  parallelFor(static_cast<int>(share.size()), [&](int first, int last) {
    for (int c = first; c < last; ++c) {
      const auto& [a, b, d, e] = cells.cells[c];
      share[c] = meanShare(membership, {X[a], X[b], X[d], X[e]});
    }
  });
  return share;
}

void mixCells(const Scene& scene, const std::vector<double>& share, std::vector<int>& cell_material) {
  for (std::size_t c = 0; c < cell_material.size(); ++c)
    if (cell_material[c] == 0) cell_material[c] = mixtureOf(scene, share[c]);
}

void mixPoints(const Scene& scene, const std::vector<double>& share, const BackgroundCells& cells,
               const IntegrationPoints& points, std::vector<int>& point_material) {
  for (std::size_t q = 0; q < point_material.size(); ++q) {
    if (point_material[q] != 0) continue;
    const int one = points.cell[q], other = points.other_cell.empty() ? -1 : points.other_cell[q];
    double mean = share[one];
    if (other >= 0)
      mean = (cells.volume[one] * share[one] + cells.volume[other] * share[other]) /
             (cells.volume[one] + cells.volume[other]);
    point_material[q] = mixtureOf(scene, mean);
  }
}

}  // namespace palpate
