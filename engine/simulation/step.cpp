#include "simulation/step.h"

#include <algorithm>
#include <cmath>

#include "base/float4.h"
#include "mechanics/internal_forces.h"
#include "simulation/trust.h"
#include "simulation/workspace.h"

namespace palpate {
namespace {

/// Factors of the damped central difference, paper eq. 12.
struct Integrator {
  double alpha, beta;
  Integrator(double h, double c) : alpha(2 * h * h / (2 + c * h)), beta((2 - c * h) / (2 + c * h)) {}
};

/// Shares of the nodes that threads take whole. Their number is fixed, so that no result depends on the threads'.
constexpr int node_parts = 8;

/// Runs each(part, begin, end) for all parts [begin, end) of the nodes.
template <class Each>
void forNodes(const Model& model, Workspace& workspace, Each each) {
  const auto border = [n = std::int64_t{model.nodeCount()}](int part) {
    return static_cast<int>(n * part / node_parts);
  };
  shareOut(workspace.team, node_parts, [&](int part) { each(part, border(part), border(part + 1)); });
}

/// du~ = beta du + alpha M^-1 f                                            (eq. 22)
/// The increment is what is kept: 2u - u_prev in float32 loses a thousand times more.
/// @return f . du, J, of the internal forces on the last step's increments
double predict(const Model& model, const Integrator& integrator, State& state, Workspace& workspace) {
  const auto alpha = static_cast<float>(integrator.alpha), beta = static_cast<float>(integrator.beta);
  double of[node_parts];
  forNodes(model, workspace, [&](int part, int begin, int end) {
    sumForces(model.kernel, workspace.kernel, begin, end, workspace.f.data());
    Group work{};
    for (int i = begin; i < end; ++i) {
      const Group du = load(state.du[i]), f = load(workspace.f[i]);
      work += f * du;
      workspace.previous_du[i] = state.du[i];
      store(state.du[i], beta * du + alpha * model.inverse_mass[i] * f);
    }
    of[part] = static_cast<double>(work[0]) + work[1] + work[2];
  });
  double sum = 0;
  for (const double w : of) sum += w;
  return sum;
}

/// A spring between the pulled skin vertex and the pointer.
void pull(const Model& model, const Command& command, State& state) {
  const int v = command.pull_vertex;
  if (v < 0 || v >= static_cast<int>(model.skin.surface.vertices.size())) return;
  const auto& skin = model.skin;
  Vec3 x = skin.surface.vertices[v];
  double mobility = 0;  // N^T M^-1 N
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) {
    x += skin.N[e] * (toVec3(state.u[skin.node[e]]) + toVec3(state.du[skin.node[e]]));
    mobility += static_cast<double>(skin.N[e]) * skin.N[e] * model.inverse_mass[skin.node[e]];
  }
  // Stiff enough to lead, soft enough to leave the stable step alone: the spring alone would
  // correct a fiftieth of the gap in one step.
  constexpr double share_per_step = 0.02;
  Vec3 gap = command.pull_target - x;
  const double longest = 2 * model.scene.tool.radius;  // a pointer far away pulls no harder than this
  if (gap.norm() > longest) gap *= longest / gap.norm();
  const Vec3 impulse = share_per_step / mobility * gap;  // alpha * force
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e)
    addScaled(state.du[skin.node[e]], skin.N[e] * model.inverse_mass[skin.node[e]], toFloat4(impulse));
}

/// The node that moved furthest, and the first that is not finite.
struct Moved {
  float distance2 = 0;  // m^2
  int node = -1, not_finite = -1;
  double work = 0;          // J, f . du
  double kinetic = 0;       // kg m^2, sum of m |du|^2
  double acceleration = 0;  // kg m^2, sum of m |du - previous du|^2
};

/// u += du of nodes [begin, end), compensated (Kahan): the error of u does not grow with the number of steps.
Moved accumulate(const Model& model, State& state, const Workspace& workspace, int begin, int end) {
  Moved moved;
  Group work{};
  float kinetic = 0, acceleration = 0;
  for (int i = begin; i < end; ++i) {
    const Group du = load(state.du[i]), u = load(state.u[i]);
    const Group y = du + load(state.u_low[i]);
    const Group t = u + y;
    store(state.u_low[i], y - (t - u));
    store(state.u[i], t);
    work += load(workspace.f[i]) * du;
    const float d2 = du[0] * du[0] + du[1] * du[1] + du[2] * du[2];
    if (d2 > moved.distance2) {
      moved.distance2 = d2;
      moved.node = i;
    }
    const Group change = du - load(workspace.previous_du[i]);
    const auto mass = static_cast<float>(model.mass[i]);
    kinetic += mass * d2;
    acceleration += mass * (change[0] * change[0] + change[1] * change[1] + change[2] * change[2]);
    if (!(d2 <= 1e30F) && moved.not_finite < 0) moved.not_finite = i;
  }
  moved.work = static_cast<double>(work[0]) + work[1] + work[2];
  moved.kinetic = kinetic;
  moved.acceleration = acceleration;
  return moved;
}

/// u += du.
/// @return what its nodes sum up to
Moved accumulate(const Model& model, State& state, Workspace& workspace, StepReport& report) {
  Moved of[node_parts];
  forNodes(model, workspace,
           [&](int part, int begin, int end) { of[part] = accumulate(model, state, workspace, begin, end); });
  Moved moved;
  for (const Moved& f : of) {
    if (f.distance2 > moved.distance2) {
      moved.distance2 = f.distance2;
      moved.node = f.node;
    }
    if (moved.not_finite < 0) moved.not_finite = f.not_finite;
    moved.work += f.work;
    moved.kinetic += f.kinetic;
    moved.acceleration += f.acceleration;
  }
  report.kinetic_energy = 0.5 * moved.kinetic / (model.dt * model.dt);
  report.max_increment = std::sqrt(moved.distance2);
  report.worst_node = moved.not_finite < 0 ? moved.node : moved.not_finite;
  if (moved.not_finite >= 0) report.flags |= kNotFinite;
  if (report.max_increment > model.max_increment) report.flags |= kBlowUp;
  return moved;
}

/// The later step's forces with the worst that either saw.
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
  both.energy_error = std::max(earlier.energy_error, later.energy_error);
  both.step_share = std::max(earlier.step_share, later.step_share);
  if (earlier.flags & kNotFinite) both.worst_node = earlier.worst_node;
  return both;
}

}  // namespace

StepReport step(const Model& model, State& state, const Pose& tool_pose, const Command& command, Workspace& workspace) {
  const Integrator integrator(model.dt, model.scene.damping);
  const double time = static_cast<double>(state.step + 1) * model.dt;
  StepReport report;

  // f = -F_int(u)                                                         (eq. 31)
  const ForceReport forces =
      internalForces(model.kernel, state.live.kernel, state.u.data(), workspace.kernel, workspace.team);

  // du~ = beta du + alpha M^-1 f, then what the user and the tool add      (eq. 22)
  state.energy.work -= 0.5 * predict(model, integrator, state, workspace);
  pull(model, command, state);
  report.tool_force =
      solveContact(model.skin, model.scene.tool, tool_pose, state.tool_pose, state.live.friction, integrator.alpha,
                   model.inverse_mass.data(), state.u.data(), state.du.data(), state.contact);

  // du = du~ + P (du_bar - Phi du~)                                       (eqs. 23-25)
  report.base_reaction = imposeBoundary(model.boundary, time, model.dt, integrator.alpha, model.inverse_mass.data(),
                                        nullptr, state.du.data(), workspace.boundary, workspace.team);
  // u += du
  const Moved moved = accumulate(model, state, workspace, report);
  report.strain_energy = forces.strain_energy;
  report.energy_error =
      state.energy.update(forces.strain_energy, report.kinetic_energy, moved.acceleration / (8 * model.dt * model.dt),
                          model.dt, model.rest_energy);
  state.energy.work -= 0.5 * moved.work;
  report.volume_change = forces.volume_change / model.cell_volume;
  report.pressure_over_shear = -report.volume_change * bulkOverShear(state.live);
  report.nearly_incompressible = nearlyIncompressible(state.live);
  report.step_share = stepShare(model, state.live, forces.max_cof2);
  state.tool_pose = tool_pose;
  ++state.step;

  report.min_J = forces.min_J;
  report.worst_point = forces.worst_point;
  report.inverted_points = forces.inverted_points;
  report.contact_count = state.contact.contact_count;
  report.max_penetration = state.contact.max_penetration;
  if (forces.inverted_points > 0) report.flags |= kInvertedPoints;
  if (state.contact.overflow) report.flags |= kContactOverflow;
  if (report.max_penetration > 0.2 * model.scene.tool.radius) report.flags |= kDeepContact;
  return report;
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
  StepReport total;
  for (int k = 1; k <= model.substeps_per_tick; ++k) {
    if (command.stop != nullptr && command.stop->load(std::memory_order_relaxed)) {
      total.cut_short = true;
      return total;
    }
    total = worstOf(total, step(model, state, poseAt(share * k / model.substeps_per_tick), command, workspace));
  }
  ++state.tick;
  return total;
}

}  // namespace palpate
