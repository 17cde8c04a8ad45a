#include "step/step_report.h"

#include <algorithm>
#include <cmath>

#include "step/tool_bodies.h"

namespace palpate {
namespace {

/// Deeper than this share of the tool's radius, or of the spacing between two bodies, the contact is no longer trusted
/// to push out evenly.
constexpr double deep_contact = 0.2;

std::uint32_t flagsOf(const Model& model, const StepReport& report, const StepOutcome& outcome, const State& state) {
  std::uint32_t flags = 0;
  if (outcome.moved.not_finite >= 0) flags |= kNotFinite;
  if (report.max_increment > model.max_increment) flags |= kBlowUp;
  if (report.inverted_points > 0) flags |= kInvertedPoints;
  if (outcome.contact.skins.overflow) flags |= kContactOverflow;
  for (const ContactState& contact : state.contact)
    if (contact.overflow && contact.contact_count > 0) flags |= kContactOverflow;
  if (report.max_penetration > deep_contact * model.scene.tools[0].shape.radius) flags |= kDeepContact;
  if (isTooDeep(model, outcome.contact.skins)) flags |= kDeepContact;
  return flags;
}

/// Contact of all tools.
void addTools(const Model& model, const StepOutcome& outcome, const State& state, StepReport& report) {
  report.loads = outcome.loads;
  report.tool_force = outcome.loads[0].force;
  report.contact_count = outcome.loads[0].contact_count;
  const double radius = model.tools.first().shape.radius;
  for (std::size_t b = 0; b < state.contact.size(); ++b) {
    const double of_own = radius / model.tools.body[b].shape.radius;
    report.max_penetration = std::max(report.max_penetration, state.contact[b].max_penetration * of_own);
  }
}

/// The largest force that a tool has on it, or a finger, or a rigid body.
double largestForce(const StepOutcome& outcome) {
  double largest = 0;
  for (const ToolLoad& load : outcome.loads) largest = std::max({largest, load.force.norm(), load.pinch});
  for (const RigidLoad& load : outcome.contact.rigid) largest = std::max(largest, load.force.norm());
  return largest;
}

/// The force that accelerates the added mass, as a share of the largest recent force of tool or base. Smoothed over
/// 10 ms, since vibrations take turns.
double addedInertia(const Model& model, const StepOutcome& outcome, LocalMass& local) {
  constexpr double smoothing = 0.01, memory = 0.25;  // s
  if (!local.active) {
    local.momentum.setZero();
    local.force = 0;
    return 0;
  }
  const Vec3 change = outcome.moved.added_momentum / model.dt - local.momentum;
  local.momentum += model.dt / (smoothing + model.dt) * change;
  local.force = std::max(
      {local.force * std::max(0.0, 1 - model.dt / memory), largestForce(outcome), outcome.base_reaction.norm()});
  return local.force > 0 ? change.norm() / smoothing / local.force : 0;
}

}  // namespace

bool isTooDeep(const Model& model, const SkinContact& skins) {
  return skins.max_penetration > deep_contact * model.bodies.spacing;
}

bool isTooDeep(const Model& model, const RigidLoads& rigid) {
  constexpr double deep = 0.1;  // spacings: 0.03 between points where nodes are as dense as the deformation asks for
  return std::any_of(rigid.begin(), rigid.end(),
                     [&](const RigidLoad& load) { return load.max_penetration > deep * model.bodies.spacing; });
}

int organCount(const Model& model) { return static_cast<int>(model.scene.organs.size()); }

StepReport reportOf(const Model& model, const StepOutcome& outcome, State& state) {
  const ForceReport& forces = outcome.forces;
  const Moved& moved = outcome.moved;
  const double dt2 = model.dt * model.dt;
  StepReport report;
  report.base_reaction = outcome.base_reaction;
  report.skin_penetration = outcome.contact.skins.max_penetration;
  report.skin_contact_count = outcome.contact.skins.count;
  report.rigid = outcome.contact.rigid;

  report.max_increment = std::sqrt(moved.distance2);
  report.worst_node = moved.not_finite < 0 ? moved.node : moved.not_finite;
  report.min_J = forces.min_J;
  report.worst_point = forces.worst_point;
  report.inverted_points = forces.inverted_points;
  addTools(model, outcome, state, report);

  report.strain_energy = forces.strain_energy;
  report.kinetic_energy = 0.5 * moved.kinetic / dt2;
  state.energy.work -= 0.5 * outcome.work_before;
  state.energy.relax(forces.relaxed_energy, forces.relaxation_power, model.dt);
  report.energy_error = state.energy.update(forces.strain_energy, report.kinetic_energy, moved.acceleration / (8 * dt2),
                                            model.dt, model.rest_energy);
  state.energy.work -= 0.5 * moved.work;
  report.volume_change = forces.volume_change / model.cell_volume;
  report.pressure_over_shear =
      model.patches.empty() ? -report.volume_change * bulkOverShear(state.live) : forces.max_patch_pressure;
  report.cell_pressure_over_shear = forces.max_cell_pressure;
  report.nearly_incompressible = nearlyIncompressible(state.live);
  report.step_share = outcome.masses.step_share;
  report.added_mass = outcome.masses.added;
  report.added_inertia = addedInertia(model, outcome, state.local_mass);
  report.scaled_momentum = moved.scaled_momentum / model.dt;
  report.flags = flagsOf(model, report, outcome, state);
  return report;
}

StepReport worstOf(const StepReport& earlier, const StepReport& later) {
  StepReport both = later;
  both.flags |= earlier.flags;
  both.inverted_points = std::max(earlier.inverted_points, later.inverted_points);
  both.max_penetration = std::max(earlier.max_penetration, later.max_penetration);
  if (earlier.max_increment > later.max_increment) {
    both.max_increment = earlier.max_increment;
    both.worst_node = earlier.worst_node;
  }
  if (earlier.min_J < later.min_J) {
    both.min_J = earlier.min_J;
    both.worst_point = earlier.worst_point;
  }
  for (std::size_t t = 0; t < both.loads.size(); ++t) both.loads[t].work += earlier.loads[t].work;
  both.skin_penetration = std::max(earlier.skin_penetration, later.skin_penetration);
  for (std::size_t b = 0; b < both.rigid.size(); ++b)
    both.rigid[b].max_penetration = std::max(earlier.rigid[b].max_penetration, later.rigid[b].max_penetration);
  both.energy_error = std::max(earlier.energy_error, later.energy_error);
  both.pressure_over_shear = std::max(earlier.pressure_over_shear, later.pressure_over_shear);
  both.cell_pressure_over_shear = std::max(earlier.cell_pressure_over_shear, later.cell_pressure_over_shear);
  both.step_share = std::max(earlier.step_share, later.step_share);
  both.added_mass = std::max(earlier.added_mass, later.added_mass);
  both.added_inertia = std::max(earlier.added_inertia, later.added_inertia);
  if (earlier.flags & kNotFinite) both.worst_node = earlier.worst_node;
  return both;
}

}  // namespace palpate
