#pragma once

#include <vector>

#include "base/spin_team.h"
#include "mechanics/kernel_layout.h"
#include "mechanics/relaxation.h"

namespace palpate {

/// The worst point of a force evaluation, and sums over all points.
struct ForceReport {
  float min_J = 1;
  int worst_point = -1;  // model index of the point with min J
  int inverted_points = 0;
  double strain_energy = 0;  // J, of the laws
  double volume_change = 0;  // m^3, of all points
  double max_cof2 = 3;       // largest |cof F|^2 of a point; 3 at rest
  // Largest PointStateOf::squeeze, and squeeze + other, of a point over the modulus at rest of its material in force.
  double max_squeeze = 0, max_modulus = 0;
  // Largest local pressure over the shear modulus there, 0 without node patches: of a point's patches (a mean over some
  // sixty points), and of a cell's nodes where the cells hold the volume.
  double max_patch_pressure = 0, max_cell_pressure = 0;
  // Of all points (RelaxedStress); the work that relaxation keeps from the strain energy is the first less the integral
  // of the second over time.
  double relaxed_energy = 0;    // J
  double relaxation_power = 0;  // W
};

/// Internal forces of a total-Lagrangian body.
///
///   F_q = I + sum_i u_i (x) gradN_i(X_q)          X of paper eqs. 9, 31
///   f_i = -sum_q V_q P(F_q) gradN_i(X_q)          paper eq. 31
///
/// Where the layout has node patches, the pressure K (J - 1) in P is that of node_patch.h: two passes over the
/// points, the gradients kept in between. What is beyond a limit of that comes from the cells (cell_volume.h).
///
/// A chunk is computed by one thread and sums into its own buffer; sumForces adds the buffers in chunk order, so that
/// the result does not depend on the thread count.
///
/// @param u        displacement parameters, m (node_count)
/// @param history  of materials that relax: one step of h s is done in it. Null: their equilibrium after a long time
/// Real-time: no allocation, no lock, no throw.
/// Test: mechanics/internal_forces_test.cpp (f = -d energy / du; equals the reference kernel).
template <class Real>
ForceReport internalForces(const KernelLayoutOf<Real>& layout, const KernelMaterialsOf<Real>& materials,
                           const Real4<Real>* u, KernelScratchOf<Real>& scratch, SpinTeam& team,
                           RelaxationHistoryOf<Real>* history = nullptr, double h = 0);

/// Adds up the chunks' forces of nodes [begin, end) into f.
template <class Real>
void sumForces(const KernelLayoutOf<Real>& layout, const KernelScratchOf<Real>& scratch, int begin, int end,
               Real4<Real>* f);

/// The same formula in ten lines of double: the reference that the tests compare the fast kernel with.
/// @param u, f     (node_count); f is overwritten
/// @param patches  of the points where volume is averaged over node patches, or empty
void referenceInternalForces(const ShapeTable& shape, const std::vector<double>& volume,
                             const std::vector<int>& point_material, const std::vector<Material>& materials,
                             const std::vector<Vec3>& u, std::vector<Vec3>& f, const NodePatches& patches = {});

/// Strain energy of the body, J.
double strainEnergy(const ShapeTable& shape, const std::vector<double>& volume, const std::vector<int>& point_material,
                    const std::vector<Material>& materials, const std::vector<Vec3>& u,
                    const NodePatches& patches = {});

/// F at one row of the shape table.
Mat3 deformationGradient(const ShapeTable& shape, int row, const std::vector<Vec3>& u);

}  // namespace palpate
