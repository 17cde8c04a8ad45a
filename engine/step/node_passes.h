#pragma once

#include "model/model.h"
#include "model/state.h"

namespace palpate {

class Workspace;
struct StepMasses;

/// Factors of the damped central difference, paper eq. 12: alpha in s^2.
struct Integrator {
  double alpha, beta, ch;
  Integrator(double h, double c) : alpha(2 * h * h / (2 + c * h)), beta((2 - c * h) / (2 + c * h)), ch(c * h) {}
};

// Passes over all nodes, shared by the workspace's team in parts whose number is fixed, so that no result depends on
// the number of threads. Real-time: no allocation, no lock, no throw.

/// du~ = beta du + alpha M^-1 f                                            (eq. 22)
/// with each node's own beta where mass was added, which does not damp: else a fast press would feel it.
/// The increment is what is kept: 2u - u_prev in float32 loses a thousand times more.
/// @return f . du, J, of the internal forces on the last step's increments
double predict(const Model& model, const Integrator& integrator, const StepMasses& masses, State& state,
               Workspace& workspace);

/// What the nodes' increments sum up to.
struct Moved {
  float distance2 = 0;                  // m^2, of the node that moved furthest
  int node = -1, not_finite = -1;       // that node, and the first that is not finite
  double work = 0;                      // J, f . du
  double kinetic = 0;                   // kg m^2, sum of m |du|^2
  double acceleration = 0;              // kg m^2, sum of m |du - previous du|^2
  Vec3 added_momentum = Vec3::Zero();   // kg m, sum of the mass added to squeezed tissue times du
  Vec3 scaled_momentum = Vec3::Zero();  // kg m, the same of what mass scaling added
};

/// u += du, compensated (Kahan): the error of u does not grow with the number of steps.
Moved accumulate(const Model& model, const StepMasses& masses, State& state, Workspace& workspace);

/// N, of the spring that pulls a skin vertex by `gap` (m). @param inverse_mass  (node_count) 1/kg  @param alpha  s^2
Vec3 pullForce(const Model& model, int vertex, const Vec3& gap, const float* inverse_mass, double alpha);

/// That spring between the skin vertex that the command pulls and its pointer, if there is one.
void pull(const Model& model, const Command& command, double alpha, const StepMasses& masses, State& state);

}  // namespace palpate
