#include "model/live_parameters.h"

#include <algorithm>

#include "model/model.h"
#include "model/state.h"

namespace palpate {

LiveParameters loadedParameters(const Model& model) {
  LiveParameters live;
  for (std::size_t t = 0; t < model.tools.tool.size(); ++t) live.friction[t] = model.tools.tool[t].friction;
  live.kernel = makeKernelMaterials(model.kernel, model.materials);
  return live;
}

void setMaterial(const Model& model, int index, const Material& material, State& state) {
  Material& present = state.live.kernel.materials[static_cast<std::size_t>(index)];
  const auto stiffer = static_cast<float>(material.shear_modulus / present.shear_modulus);
  const auto numbers = static_cast<std::size_t>(state.relaxation.term_count) * RelaxationHistory::batch_numbers;
  for (std::size_t b = 0; b < model.kernel.batch_material.size() && numbers > 0; ++b) {
    if (model.kernel.batch_material[b] != index) continue;
    float* const Z = state.relaxation.Z.data() + b * numbers;
    std::transform(Z, Z + numbers, Z, [&](float z) { return stiffer * z; });
  }
  present = material;
  updatePatchBulk(model.kernel, state.live.kernel);
}

double stiffening(const Material& loaded, const Material& present) {
  const double matrix =
      std::max(present.bulk_modulus / loaded.bulk_modulus, present.shear_modulus / loaded.shear_modulus);
  if (present.fibre_modulus == 0) return matrix;
  // s with s (E + f) >= matrix E + f': stretched along the fibres, a free body is held by its Young's modulus E, too.
  const double K = loaded.bulk_modulus, mu = loaded.shear_modulus, young = 9 * K * mu / (3 * K + mu);
  const double before = std::equal(loaded.fibre, loaded.fibre + 3, present.fibre) ? loaded.fibre_modulus : 0;
  return std::max(matrix, (matrix * young + present.fibre_modulus) / (young + before));
}

double stiffening(const Model& model, const LiveParameters& live) {
  double largest = model.materials.empty() ? 1 : 0;
  for (std::size_t m = 0; m < model.materials.size(); ++m)
    largest = std::max(largest, stiffening(model.materials[m], live.kernel.materials[m]));
  return largest;
}

double bulkOverShear(const LiveParameters& live) { return bulkOverShear(live.kernel.materials); }

bool nearlyIncompressible(const LiveParameters& live) { return nearlyIncompressible(live.kernel.materials); }

bool nearlyIncompressible(const std::vector<Material>& materials) {
  return std::all_of(materials.begin(), materials.end(), [](const Material& m) {
    return m.bulk_modulus > 2 * 1.45 / (3 * 0.1) * m.shear_modulus;  // Poisson's ratio 0.45
  });
}

double bulkOverShear(const std::vector<Material>& materials) {
  double largest = 0;
  for (const Material& m : materials)
    largest = std::max(largest, m.bulk_modulus / (m.shear_modulus * m.longTermShare()));
  return largest;
}

}  // namespace palpate
