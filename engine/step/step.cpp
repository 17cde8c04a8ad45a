#include "step/step.h"

#include <algorithm>
#include <cmath>

#include "mechanics/internal_forces.h"
#include "step/follow_stiffness.h"
#include "step/held_nodes.h"
#include "step/node_passes.h"
#include "step/step_report.h"
#include "step/tool_bodies.h"
#include "step/tool_contact.h"
#include "step/workspace.h"

namespace palpate {

StepReport step(const Model& model, State& state, const ToolPostures& wanted, const Command& command,
                Workspace& workspace) {
  const Integrator integrator(model.dt, model.scene.dynamics.damping);
  const double time = static_cast<double>(state.step + 1) * model.dt;
  StepOutcome outcome;

  findHoldingFriction(model, state, workspace);

  // f = -F_int(u)                                                         (eq. 31)
  outcome.forces = internalForces(model.kernel, state.live.kernel, state.u.data(), workspace.kernel, workspace.team,
                                  &state.relaxation, model.dt);

  // M, with mass added where the tissue is squeezed so far that dt would be too long
  const StepMasses masses = outcome.masses = followStiffness(model, integrator, outcome.forces, state, workspace);

  // du~ = beta du + alpha M^-1 f                                          (eq. 22)
  outcome.work_before = predict(model, integrator, masses, state, workspace);

  // What weight, loads, the user and the tools add to du~; a tool gives way to more than its max_force
  addLoads(model, time, integrator.alpha, masses, state, workspace);
  pull(model, command, integrator.alpha, masses, state);
  ToolPostures tools = wanted;
  workspace.boundary.moved_before = state.region_shift;
  moveRegions(model, state);
  workspace.boundary.moved = state.region_shift;
  const auto impose = [&](bool again) {
    return imposeBoundary(model.boundary, time, model.dt, masses.boundary_alpha, model.inverse_mass.data(), nullptr,
                          state.du.data(), workspace.boundary, workspace.team, again);
  };
  HeldNodes held([&] { impose(true); });
  const bool beside_held = touchesBesideHeld(model, state.contact, state.skins, state.rigid);
  outcome.contact = solveContacts(model, tools, integrator.alpha, masses.inverse, beside_held ? &held : nullptr, state,
                                  workspace.contact, outcome.loads);

  // Pins go where they were asked to be
  holdPins(model, integrator.alpha, masses, state, workspace.pin_force);

  // du = du~ + P (du_bar - Phi du~)                                       (eqs. 23-25)
  outcome.base_reaction = impose(false);

  // No point turns inside out; last, since what came before may do that. What holds the body is met again at the next
  // tick's begin (correctBoundaryDrift).
  workspace.compression.apply(model, workspace.kernel, outcome.forces, masses, state, workspace.team);

  // u += du
  outcome.moved = accumulate(model, masses, state, workspace);
  noteTravel(model.bodies, std::sqrt(outcome.moved.distance2), state.du.data(), state.skins);

  std::copy_n(tools.begin(), state.tool.size(), state.tool.begin());
  ++state.step;
  return reportOf(model, outcome, state);
}

StepReport tick(const Model& model, State& state, const Command& command, Workspace& workspace) {
  // Each tool follows its command no faster than the scene allows, turning included.
  const ToolWays ways(model, state, command);
  const int bodies = model.tools.bodyCount();

  // The tool travels at most `reach` until the next look, and so may the tissue in its way: what is not listed
  // can't be touched, and would be found deep inside later, which pumps energy into the tissue.
  const auto forBody = [&](int b, auto find) {
    const ToolBody& body = model.tools.body[b];
    const Pose pose = bodyPose(body, ways.end()[static_cast<std::size_t>(body.tool)]);
    find(model.skin, state.u.data(), body.shape, pose, 2 * ways.reach(body), state.contact[b],
         workspace.contact.tools[static_cast<std::size_t>(b)]);
  };
  workspace.boundary.moved = state.region_shift;
  shareOut(workspace.team, 1 + bodies, [&](int part) {
    if (part < bodies)
      forBody(part, findContactCandidates);
    else
      correctBoundaryDrift(model.boundary, static_cast<double>(state.step) * model.dt, state.u.data(),
                           state.u_low.data(), workspace.boundary);
  });
  StepReport total;
  ToolLoads near;
  for (int b = 0; b < bodies; ++b) {
    const auto tool = static_cast<std::size_t>(model.tools.body[b].tool);
    near[tool].near_count += state.contact[b].count;
    if (command.lets_go[tool]) state.contact[b].count = 0, total.flags |= kLetsGo;
    forBody(b, findFaceSamples);
  }
  // Skins that touch are looked at again within a tick of many steps: what is so stiff swings as fast as ticks come,
  // and normals of a tick ago drive it (two blocks of 100 kPa, one on the other, shook themselves apart).
  constexpr int steps_of_look = 2;
  for (int k = 1; k <= model.substeps_per_tick; ++k) {
    if ((k - 1) % steps_of_look == 0)
      findSkinPairs(model.bodies, model.skin, state.u.data(), state.du.data(),
                    std::min(steps_of_look, model.substeps_per_tick - k + 1), state.skins, workspace.contact.skins);
    const ToolPostures wanted = ways.next(state, model.substeps_per_tick - k + 1);
    total = worstOf(total, step(model, state, wanted, command, workspace));
    if (total.flags & (kNotFinite | kBlowUp)) break;  // it is lost: more steps would bring numbers that are none
  }
  ++state.tick;
  if (!model.rigid.empty()) {
    // Between its points too, some of the skin each tick.
    constexpr int shares = 128;  // a quarter of a second at 500 Hz, and 1 % of a tick
    addDeepest(model.rigid, model.skin, state.u.data(), static_cast<double>(state.step) * model.dt,
               model.bodies.spacing, static_cast<int>(state.tick % shares), shares, total.rigid);
    workspace.depth.keep(static_cast<int>(state.tick % shares) == 0, total.rigid);
    if (isTooDeep(model, total.rigid)) total.flags |= kDeepContact;
  }
  if (model.bodies.several())
    for (int k = 0; k < organCount(model); ++k)
      total.organ_force[static_cast<std::size_t>(k)] = skinForceOn(model.bodies, model.skin, k, state.skins);
  const ToolContact contact = toolContact(model, state);
  total.tool_torque = contact.torque;
  total.contact_normal = contact.normal;
  workspace.resolution.advance(model, state, total);
  total.loads[0].torque = contact.torque;
  for (int t = 1; t < model.tools.toolCount(); ++t) total.loads[t].torque = toolContact(model, state, t).torque;
  for (int t = 0; t < model.tools.toolCount(); ++t) {
    total.loads[t].near_count = near[t].near_count;
    total.loads[t].stopped = ways.stopped(t);
    if (ways.fails(t) && near[t].near_count > 0) total.flags |= kDeepContact;
  }
  return total;
}

}  // namespace palpate
