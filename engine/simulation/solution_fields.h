#pragma once

#include <vector>

#include "mechanics/relaxation.h"
#include "simulation/model.h"

namespace palpate {

/// What a displaced body looks like, for results and pictures.
struct SolutionFields {
  std::vector<Vec3> displacement;  // (node_count) the field at the nodes, m: not the parameters
  std::vector<double> J;           // (cell_count) mean over the cell's points; two cells that share one are alike
  std::vector<double> pressure;    // (cell_count) -tr(sigma)/3 of the Cauchy stress, Pa; compression is positive
  std::vector<double> von_mises;   // (cell_count) Pa
};

/// @param u        displacement parameters, m (node_count)
/// @param history  of materials that relax; empty: their equilibrium after a long time
SolutionFields solutionFields(const Model& model, const std::vector<Vec3>& u, const PointHistory& history = {});

/// First Piola-Kirchhoff stress at the integration points, Pa (point_count), with the volume law of the scene.
/// @param F  receives the deformation gradients (point_count)
std::vector<Mat3> pointStresses(const Model& model, const std::vector<Vec3>& u, std::vector<Mat3>& F,
                                const PointHistory& history = {});

}  // namespace palpate
