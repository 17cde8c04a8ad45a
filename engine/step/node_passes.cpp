#include "step/node_passes.h"

#include <algorithm>
#include <cmath>

#include "base/float4.h"
#include "contact/contact_row.h"
#include "contact/skin_forces.h"
#include "mechanics/internal_forces.h"
#include "step/follow_stiffness.h"
#include "step/workspace.h"

namespace palpate {
namespace {

/// Shares of the nodes that threads take whole. Their number is fixed, so that no result depends on the threads'.
constexpr int node_parts = 8;

/// u += du of nodes [begin, end), compensated (Kahan): the error of u does not grow with the number of steps.
Moved accumulate(const Model& model, const StepMasses& masses, State& state, const Workspace& workspace, int begin,
                 int end) {
  Moved moved;
  Group work{}, added_momentum{}, scaled_momentum{};
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
    auto mass = static_cast<float>(model.mass[i]);
    if (!model.own_share.empty()) scaled_momentum += (1 - model.own_share[i]) * mass * du;
    if (masses.factor) {
      const float own = mass;
      mass *= masses.factor[i];
      added_momentum += (mass - own) * du;
    }
    kinetic += mass * d2;
    acceleration += mass * (change[0] * change[0] + change[1] * change[1] + change[2] * change[2]);
    if (!(d2 <= 1e30F) && moved.not_finite < 0) moved.not_finite = i;
  }
  moved.work = static_cast<double>(work[0]) + work[1] + work[2];
  moved.kinetic = kinetic;
  moved.acceleration = acceleration;
  moved.added_momentum = Vec3(added_momentum[0], added_momentum[1], added_momentum[2]);
  moved.scaled_momentum = Vec3(scaled_momentum[0], scaled_momentum[1], scaled_momentum[2]);
  return moved;
}

}  // namespace

double predict(const Model& model, const Integrator& integrator, const StepMasses& masses, State& state,
               Workspace& workspace) {
  const auto alpha = static_cast<float>(integrator.alpha), beta = static_cast<float>(integrator.beta);
  const auto ch = static_cast<float>(integrator.ch);
  double of[node_parts];
  shareRows(workspace.team, node_parts, model.nodeCount(), [&](int part, int begin, int end) {
    sumForces(model.kernel, workspace.kernel, begin, end, workspace.f.data());
    Group work{};
    const float* const own_share = model.own_share.empty() ? nullptr : model.own_share.data();
    for (int i = begin; i < end; ++i) {
      const Group du = load(state.du[i]), f = load(workspace.f[i]);
      work += f * du;
      const float own = own_share ? ch * own_share[i] : ch;
      if (masses.factor && masses.factor[i] != 1.0F) {
        const Group kept = masses.kept[i] * du;
        const float twice = 2 * masses.factor[i];
        store(workspace.previous_du[i], kept);
        store(state.du[i], (twice - own) / (twice + own) * kept + alpha * masses.inverse[i] * f);
      } else {
        workspace.previous_du[i] = state.du[i];
        store(state.du[i], (own_share ? (2 - own) / (2 + own) : beta) * du + alpha * masses.inverse[i] * f);
      }
    }
    of[part] = static_cast<double>(work[0]) + work[1] + work[2];
  });
  double sum = 0;
  for (const double w : of) sum += w;
  return sum;
}

Moved accumulate(const Model& model, const StepMasses& masses, State& state, Workspace& workspace) {
  Moved of[node_parts];
  shareRows(workspace.team, node_parts, model.nodeCount(),
            [&](int part, int begin, int end) { of[part] = accumulate(model, masses, state, workspace, begin, end); });
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
    moved.added_momentum += f.added_momentum;
    moved.scaled_momentum += f.scaled_momentum;
  }
  return moved;
}

Vec3 pullForce(const Model& model, int vertex, const Vec3& gap, const float* inverse_mass, double alpha) {
  // Stiff enough to lead, soft enough to leave the stable step alone: the spring alone would
  // correct a fiftieth of the gap in one step.
  constexpr double share_per_step = 0.02;
  const double longest = 2 * model.scene.tools[0].shape.radius;  // a pointer far away pulls no harder than this
  const double share = share_per_step * std::min(1.0, longest / gap.norm());
  return share / (static_cast<double>(compliance(model.skin, vertex, inverse_mass)) * alpha) * gap;
}

void pull(const Model& model, const Command& command, double alpha, const StepMasses& masses, State& state) {
  const int v = command.pull_vertex;
  const SkinModel& skin = model.skin;
  if (v < 0 || v >= skin.vertexCount()) return;
  Vec3 x = skinPosition(skin, v, state.u.data());
  x += interpolateAtVertex(skin, v, state.du.data()).head<3>().cast<double>();
  const Vec3 force = pullForce(model, v, command.pull_target - x, masses.inverse, alpha);
  applyForce(skin, v, lanesOf(force), static_cast<float>(alpha), masses.inverse, state.du.data());
}

}  // namespace palpate
