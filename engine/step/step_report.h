#pragma once

#include "mechanics/internal_forces.h"
#include "model/model.h"
#include "model/state.h"
#include "step/follow_stiffness.h"
#include "step/node_passes.h"

namespace palpate {

/// What the physics of one step leaves for its report.
struct StepOutcome {
  ForceReport forces;
  StepMasses masses;
  double work_before = 0;             // J, of the internal forces on the increments before the step
  Moved moved;                        // the step's own increments
  ToolLoads loads;                    // as StepReport has them
  Vec3 base_reaction = Vec3::Zero();  // N
  ContactForces contact;              // of skins and rigid bodies
};

/// Whether bodies are so deep in one another that the contact is no longer trusted.
bool isTooDeep(const Model& model, const SkinContact& skins);
bool isTooDeep(const Model& model, const RigidLoads& rigid);

/// How many organs the scene has.
int organCount(const Model& model);

/// The report of a step that has been done; keeps the state's account of energy.
/// Real-time: no allocation, no lock, no throw.
StepReport reportOf(const Model& model, const StepOutcome& outcome, State& state);

/// The later step's forces with the worst that either saw.
StepReport worstOf(const StepReport& earlier, const StepReport& later);

}  // namespace palpate
