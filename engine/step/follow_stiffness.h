#pragma once

#include "mechanics/internal_forces.h"
#include "model/model.h"
#include "model/state.h"
#include "step/node_passes.h"

namespace palpate {

class Workspace;

/// Where mass is added, dt is at most this share of the stable step.
constexpr double followed_step_share = 0.9;

/// Masses of one step.
struct StepMasses {
  const float* inverse = nullptr;  // (node_count) 1/kg; with the integrator's alpha: alpha inverse[i] is node i's own
  const float* factor = nullptr;   // (node_count) of the model's masses; null: 1
  const float* kept = nullptr;     // (node_count) of the last increment, as mass was added; with `factor`
  double boundary_alpha = 0;       // s^2, with which the boundary's tractions are right
  double step_share = 0;           // dt over the stable step, with these masses
  double added = 0;                // mass, as a share of the body's own
};

/// Masses that follow the deformed tissue's stiffness (mechanics/local_mass.h). At once where it rises, the momentum
/// kept; 2 % a step where it falls, the velocity kept: neither adds energy. Mass that is added is not damped. Nothing
/// is computed while dt is no more than 0.9 of the stable step with the model's own masses.
/// @param forces  of this step; the kernel's scratch has its points' |cof F|^2
/// Real-time: no allocation, no lock, no throw. The team shares it in fixed parts.
StepMasses followStiffness(const Model& model, const Integrator& integrator, const ForceReport& forces, State& state,
                           Workspace& workspace);

}  // namespace palpate
