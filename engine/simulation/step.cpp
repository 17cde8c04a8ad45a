#include "simulation/step.h"

#include "mechanics/internal_forces.h"
#include "simulation/follow_stiffness.h"
#include "simulation/node_passes.h"
#include "simulation/step_report.h"
#include "simulation/tool_contact.h"
#include "simulation/workspace.h"

namespace palpate {

StepReport step(const Model& model, State& state, const Pose& tool_pose, const Command& command, Workspace& workspace) {
  const Integrator integrator(model.dt, model.scene.damping);
  const double time = static_cast<double>(state.step + 1) * model.dt;
  StepOutcome outcome;

  // f = -F_int(u)                                                         (eq. 31)
  outcome.forces = internalForces(model.kernel, state.live.kernel, state.u.data(), workspace.kernel, workspace.team,
                                  &state.relaxation, model.dt);

  // M, with mass added where the tissue is squeezed so far that dt would be too long
  const StepMasses masses = outcome.masses = followStiffness(model, integrator, outcome.forces, state, workspace);

  // du~ = beta du + alpha M^-1 f                                          (eq. 22)
  outcome.work_before = predict(model, integrator, masses, state, workspace);

  // What the user and the tool add to du~
  pull(model, command, masses, state);
  outcome.tool_force = solveContact(model.skin, model.scene.tool, tool_pose, state.tool_pose, state.live.friction,
                                    integrator.alpha, masses.inverse, state.u.data(), state.du.data(), state.contact);

  if (!model.skull.empty())
    outcome.skull = solveSkull(model.skull, model.skin, integrator.alpha, masses.inverse, state.u.data(),
                               state.du.data(), state.skull);

  // du = du~ + P (du_bar - Phi du~)                                       (eqs. 23-25)
  outcome.base_reaction =
      imposeBoundary(model.boundary, time, model.dt, masses.boundary_alpha, model.inverse_mass.data(), nullptr,
                     state.du.data(), workspace.boundary, workspace.team);

  // u += du
  outcome.moved = accumulate(model, masses, state, workspace);

  state.tool_pose = tool_pose;
  ++state.step;
  return reportOf(model, outcome, state);
}

StepReport tick(const Model& model, State& state, const Command& command, Workspace& workspace) {
  // The tool follows its command no faster than the scene allows, turning included.
  const Pose from = state.tool_pose;
  const double reach = model.scene.tool_max_speed / model.scene.rate_hz;
  const double wanted = largestTravel(model.scene.tool, from, command.tool_target);
  const double share = wanted > reach ? reach / wanted : 1;
  const auto poseAt = [&](double s) {
    Pose pose;
    pose.position = from.position + s * (command.tool_target.position - from.position);
    pose.orientation = s >= 1 ? command.tool_target.orientation
                              : from.orientation.slerp(s, command.tool_target.orientation).normalized();
    return pose;
  };

  // The tool travels at most `reach` until the next look, and so may the tissue in its way: what is not listed
  // can't be touched, and would be found deep inside later, which pumps energy into the tissue.
  const Pose arrived = poseAt(share);
  shareOut(workspace.team, 2, [&](int part) {
    if (part == 0)
      findContactCandidates(model.skin, state.u.data(), model.scene.tool, arrived, 2 * reach, state.contact);
    else
      correctBoundaryDrift(model.boundary, static_cast<double>(state.step) * model.dt, state.u.data(),
                           state.u_low.data(), workspace.boundary);
  });
  findFaceSamples(model.skin, state.u.data(), model.scene.tool, arrived, 2 * reach, state.contact);
  StepReport total;
  for (int k = 1; k <= model.substeps_per_tick; ++k) {
    if (command.stop != nullptr && command.stop->load(std::memory_order_relaxed)) {
      total.cut_short = true;
      return total;
    }
    total = worstOf(total, step(model, state, poseAt(share * k / model.substeps_per_tick), command, workspace));
  }
  ++state.tick;
  const ToolContact contact = toolContact(model, state);
  total.tool_torque = contact.torque;
  total.contact_normal = contact.normal;
  return total;
}

}  // namespace palpate
