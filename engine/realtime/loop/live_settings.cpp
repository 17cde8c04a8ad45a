#include "realtime/loop/live_settings.h"

#include <algorithm>
#include <cmath>

#include "base/float4.h"
#include "mechanics/materials/material_law.h"

namespace palpate {
namespace {

std::vector<Request> settingsOf(const Model& model) {
  std::vector<Request> requests;
  for (int t = 0; t < model.tools.toolCount(); ++t)
    requests.push_back(Request::setFriction(model.tools.tool[static_cast<std::size_t>(t)].friction, t));
  for (const Request& load : {Request::setGravity(model.scene.dynamics.gravity), Request::setForce(-1, Vec3::Zero()),
                              Request::unpin(-1), Request::moveRegion(-1, Vec3::Zero())})
    requests.push_back(load);
  if (model.materials.size() != model.scene.materials.size()) return requests;  // mixed ones can't be changed live
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    requests.push_back(Request::setMaterial(static_cast<int>(m), model.materials[m]));
  }
  return requests;
}

/// Whether something is beside the scene's where a request changes it.
bool acts(const LiveLoads& loads, const Request& request) {
  using Kind = Request::Kind;
  const bool all = request.index < 0;
  switch (request.kind) {
    case Kind::SetGravity:
      return !loads.gravity.isZero(0);
    case Kind::SetForce:
      return all ? loads.forces.count > 0 : loads.forces.has(request.index);
    case Kind::Pin:
    case Kind::Unpin:
      return all ? loads.pins.count > 0 : loads.pins.has(request.index);
    default:
      return all ? loads.region_shift.any() : !loads.region_shift.of[static_cast<std::size_t>(request.index)].isZero(0);
  }
}

}  // namespace

bool changeLoads(const Request& request, int vertex_count, int boundary_count, const Vec3& gravity, LiveLoads& loads) {
  using Kind = Request::Kind;
  if (!request.point.allFinite()) return false;
  const bool all = request.index < 0, is_vertex = request.index < vertex_count;
  switch (request.kind) {
    case Kind::SetGravity:
      loads.gravity = request.point - gravity;
      return true;
    case Kind::SetForce:
      if (all) loads.forces = {};
      return all || (is_vertex && loads.setForce(request.index, request.point));
    case Kind::Pin:
      return !all && is_vertex && loads.pins.put(request.index, request.point);
    case Kind::Unpin:
      if (all) loads.pins = {};
      if (is_vertex) loads.pins.drop(request.index);
      return is_vertex;
    case Kind::MoveRegion:
      if (all) loads.region_shift = {};
      if (request.index >= std::min(boundary_count, BoundaryShifts::max_count)) return false;
      if (!all) loads.region_shift.of[static_cast<std::size_t>(request.index)] = request.point;
      return true;
    default:
      return false;
  }
}

std::vector<Request> settingsInForce(const Model& model, const LiveParameters& live) {
  std::vector<Request> requests;
  for (std::size_t t = 0; t < model.tools.tool.size(); ++t)
    if (live.friction[t] != model.tools.tool[t].friction)
      requests.push_back(Request::setFriction(live.friction[t], static_cast<int>(t)));
  const LiveLoads& loads = live.loads;
  if (!loads.gravity.isZero(0)) requests.push_back(Request::setGravity(loads.gravity + model.scene.dynamics.gravity));
  for (std::size_t k = 0; k < static_cast<std::size_t>(loads.forces.count); ++k)
    requests.push_back(Request::setForce(loads.forces.vertex[k], toVec3(loads.forces.value[k])));
  for (std::size_t k = 0; k < static_cast<std::size_t>(loads.pins.count); ++k)
    requests.push_back(Request::pin(loads.pins.vertex[k], toVec3(loads.pins.value[k])));
  for (std::size_t b = 0; b < BoundaryShifts::max_count; ++b)
    if (const Vec3& shift = loads.region_shift.of[b]; !shift.isZero(0))
      requests.push_back(Request::moveRegion(static_cast<int>(b), shift));
  for (std::size_t m = 0; m < model.materials.size(); ++m)
    if (!(live.kernel.materials[m] == model.materials[m]))
      requests.push_back(Request::setMaterial(static_cast<int>(m), live.kernel.materials[m]));
  return requests;
}

LiveSettings::LiveSettings(const Model& model, Physics& physics)
    : physics_(physics),
      tool_count_(model.tools.toolCount()),
      material_count_(static_cast<int>(model.materials.size())),
      vertex_count_(model.skin.vertexCount()),
      boundary_count_(static_cast<int>(model.boundary.motions.size())),
      gravity_(model.scene.dynamics.gravity),
      loaded_(settingsOf(model)),
      friction_(physics.state().live.friction) {}

LiveSettings::Answer LiveSettings::apply(const Request& request) {
  if (request.kind == Request::Kind::SetFriction) return setFriction(request.index, request.value);
  if (request.kind == Request::Kind::SetMaterial) return setMaterial(request.index, request.material);
  return setLoad(request);
}

LiveSettings::Answer LiveSettings::setLoad(const Request& request) {
  LiveLoads loads = physics_.state().live.loads;
  if (!changeLoads(request, vertex_count_, boundary_count_, gravity_, loads)) return {};
  if (loads == physics_.state().live.loads) return {};
  const bool acted = acts(physics_.state().live.loads, request), acts_now = acts(loads, request);
  physics_.setLoads(loads);
  if (acted == acts_now) return {Outcome::Changed};
  return {Outcome::Changed, 0, acts_now ? 1 : 0};
}

LiveSettings::Answer LiveSettings::setFriction(int tool, double coefficient) {
  if (tool < 0 || tool >= tool_count_ || !std::isfinite(coefficient) || coefficient < 0) return {};
  double& asked = friction_[static_cast<std::size_t>(tool)];
  if (coefficient == asked) return {};
  asked = coefficient;
  physics_.setFriction(tool, coefficient);
  return {Outcome::Changed};
}

LiveSettings::Answer LiveSettings::setMaterial(int index, const Material& material) {
  const double modulus = material.waveModulus();
  if (index < 0 || index >= material_count_ || !std::isfinite(modulus) || modulus <= 0 || relaxationProblem(material))
    return {};
  const double excess = physics_.setMaterial(index, material);
  if (excess > 0) return {Outcome::Refused, excess};
  return {Outcome::Changed};
}

}  // namespace palpate
