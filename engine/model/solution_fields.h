#pragma once

#include <vector>

#include "mechanics/relaxation.h"
#include "model/model.h"

namespace palpate {

/// What a displaced body looks like, for results and pictures.
struct SolutionFields {
  std::vector<Vec3> displacement;  // (node_count) the field at the nodes, m: not the parameters
  std::vector<double> J;           // (cell_count) mean over the cell's points; two cells that share one are alike
  std::vector<double> pressure;    // (cell_count) -tr(sigma)/3 of the Cauchy stress, Pa; compression is positive
  std::vector<double> von_mises;   // (cell_count) Pa
};

/// @param u        displacement parameters, m (node_count)
/// @param history   of materials that relax; empty: their equilibrium after a long time
/// @param friction  that holds vertices of the cells, Pa (CellVolumeScratchOf::friction); empty: none
/// @param in_force  of a state's live parameters; null: the materials that the model was loaded with
SolutionFields solutionFields(const Model& model, const std::vector<Vec3>& u, const PointHistory& history = {},
                              const AlignedVector<float>& friction = {}, const KernelMaterials* in_force = nullptr);

/// First Piola-Kirchhoff stress at the integration points, Pa (point_count), with the volume law of the scene.
/// @param F  receives the deformation gradients (point_count)
std::vector<Mat3> pointStresses(const Model& model, const std::vector<Vec3>& u, std::vector<Mat3>& F,
                                const PointHistory& history = {}, const AlignedVector<float>& friction = {},
                                const KernelMaterials* in_force = nullptr);

/// A kernel's history by points. @param h  s, of the steps that it was kept in
template <class Real>
PointHistory pointHistory(const KernelLayoutOf<Real>& kernel, const RelaxationHistoryOf<Real>& history, int point_count,
                          double h) {
  PointHistory result{history.term_count, h, {}};
  const auto terms = static_cast<std::size_t>(history.term_count);
  result.Z.resize(terms * static_cast<std::size_t>(point_count));
  for (std::size_t p = 0; p < kernel.point.size(); ++p)
    for (std::size_t i = 0; i < terms && kernel.point[p] >= 0; ++i) {
      const Real* z = &history.Z[(p / 16 * terms + i) * 96 + p % 16];
      result.Z[static_cast<std::size_t>(kernel.point[p]) * terms + i] << z[0], z[80], z[64], z[80], z[16], z[48], z[64],
          z[48], z[32];
    }
  return result;
}

}  // namespace palpate
