#include "realtime/loop/live_settings.h"

#include <cmath>

#include "mechanics/materials/material_law.h"

namespace palpate {
namespace {

std::vector<Request> settingsOf(const Model& model) {
  std::vector<Request> requests{Request::setFriction(model.scene.friction), Request::setGravity(model.scene.gravity),
                                Request::setForce(-1, Vec3::Zero())};
  if (model.materials.size() != model.scene.materials.size()) return requests;  // mixed ones can't be changed live
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    requests.push_back(Request::setMaterial(static_cast<int>(m), model.materials[m]));
  }
  return requests;
}

}  // namespace

LiveSettings::LiveSettings(const Model& model, Physics& physics)
    : physics_(physics),
      material_count_(static_cast<int>(model.materials.size())),
      vertex_count_(model.skin.vertexCount()),
      gravity_(model.scene.gravity),
      loaded_(settingsOf(model)),
      friction_(physics.state().live.friction) {}

LiveSettings::Answer LiveSettings::apply(const Request& request) {
  if (request.kind == Request::Kind::SetFriction) return setFriction(request.value);
  if (request.kind == Request::Kind::SetMaterial) return setMaterial(request.index, request.material);
  if (request.kind == Request::Kind::SetGravity || request.kind == Request::Kind::SetForce) return setLoad(request);
  return {};
}

LiveSettings::Answer LiveSettings::setLoad(const Request& request) {
  if (!request.point.allFinite()) return {};
  const LiveLoads before = physics_.state().live.loads;
  LiveLoads loads = before;
  if (request.kind == Request::Kind::SetGravity) {
    loads.gravity = request.point - gravity_;
  } else if (request.index < 0) {
    loads = {};
    loads.gravity = before.gravity;
  } else if (request.index >= vertex_count_ || !loads.setForce(request.index, request.point)) {
    return {};
  }
  if (loads == before) return {};
  physics_.setLoads(loads);
  return {Outcome::Changed};
}

LiveSettings::Answer LiveSettings::setFriction(double coefficient) {
  if (!std::isfinite(coefficient) || coefficient < 0 || coefficient == friction_) return {};
  friction_ = coefficient;
  physics_.setFriction(coefficient);
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
