#include "step/apply_loads.h"

#include <algorithm>

#include "base/float4.h"
#include "contact/skin_forces.h"
#include "step/follow_stiffness.h"
#include "step/workspace.h"

namespace palpate {
namespace {

/// `wanted`, or as much of it as goes in one step.
Vec3 inOneStep(const Model& model, const Vec3& wanted) {
  const double longest = model.scene.tools[0].max_speed * model.dt, length = wanted.norm();
  return length > longest ? Vec3(longest / length * wanted) : wanted;
}

/// Weight and surface loads.
void addSceneLoads(const Model& model, double time, float alpha, const StepMasses& masses, State& state,
                   Workspace& workspace) {
  constexpr int load_parts = 8;  // fixed, so that no result depends on the threads' number
  const SurfaceLoads& loads = model.surface_loads;
  if (model.weight.empty() && loads.empty()) return;
  evaluate(loads, time, state.u.data(), workspace.surface_loads, workspace.team);
  shareRows(workspace.team, load_parts, state.du.size(), [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Group f = loadOnNode(loads, workspace.surface_loads, i);
      if (!model.weight.empty()) f += load(toFloat4(toVec3(model.weight[i])));
      store(state.du[i], load(state.du[i]) + alpha * masses.inverse[i] * f);
    }
  });
}

}  // namespace

AlignedVector<float> tissueMass(const Model& model) {
  std::vector<double> mass(model.X.size(), 0);
  const ShapeTable& shape = model.point_shape;
  for (int q = 0; q < model.pointCount(); ++q) {
    const double of_point = model.point_volume[q] * model.materials[model.point_material[q]].density;
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) mass[shape.node[e]] += of_point * shape.N[e];
  }
  return AlignedVector<float>(mass.begin(), mass.end());
}

void addLoads(const Model& model, double time, double alpha, const StepMasses& masses, State& state,
              Workspace& workspace) {
  const auto a = static_cast<float>(alpha);
  addSceneLoads(model, time, a, masses, state, workspace);
  const LiveLoads& loads = state.live.loads;
  const AlignedVector<float>& tissue_mass = workspace.tissue_mass;
  if (!loads.gravity.isZero(0)) {
    const Group g = load(toFloat4(loads.gravity));
    for (std::size_t i = 0; i < tissue_mass.size(); ++i)
      store(state.du[i], load(state.du[i]) + a * masses.inverse[i] * tissue_mass[i] * g);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(loads.forces.count); ++k) {
    const Float4& f = loads.forces.value[k];
    applyForce(model.skin, loads.forces.vertex[k], Eigen::Vector4f(f.x, f.y, f.z, 0), a, masses.inverse,
               state.du.data());
  }
}

void holdPins(const Model& model, double alpha, const StepMasses& masses, State& state, VertexValues& force) {
  constexpr int sweeps = 4;
  const VertexValues& pins = state.live.loads.pins;
  const SkinModel& skin = model.skin;
  if (pins.count == 0 && force.count == 0) return;
  force = pins;
  std::fill_n(force.value.begin(), pins.count, Float4{});
  for (int sweep = 0; sweep < (pins.count > 1 ? sweeps : pins.count); ++sweep)
    for (std::size_t k = 0; k < static_cast<std::size_t>(pins.count); ++k) {
      const int v = pins.vertex[k];
      Vec3 x = skin.surface.vertices[static_cast<std::size_t>(v)], dx = Vec3::Zero();
      double mobility = 0;  // N^T M^-1 N
      for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) {
        const int i = skin.node[e];
        x += skin.N[e] * toVec3(state.u[i]);
        dx += skin.N[e] * toVec3(state.du[i]);
        mobility += static_cast<double>(skin.N[e]) * skin.N[e] * masses.inverse[i];
      }
      const Vec3 impulse = 1 / mobility * (inOneStep(model, toVec3(pins.value[k]) - x) - dx);
      for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e)
        addScaled(state.du[skin.node[e]], skin.N[e] * masses.inverse[skin.node[e]], toFloat4(impulse));
      addScaled(force.value[k], static_cast<float>(1 / alpha), toFloat4(impulse));
    }
}

void moveRegions(const Model& model, State& state) {
  for (std::size_t b = 0; b < BoundaryShifts::max_count; ++b) {
    const Vec3 &wanted = state.live.loads.region_shift.of[b], gap = wanted - state.region_shift.of[b];
    const Vec3 step = inOneStep(model, gap);
    state.region_shift.of[b] = step == gap ? wanted : Vec3(state.region_shift.of[b] + step);
  }
}

}  // namespace palpate
