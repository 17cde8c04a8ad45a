#include "realtime/loop/live_settings.h"

#include <cmath>

#include "mechanics/materials/material_law.h"

namespace palpate {
namespace {

std::vector<Request> settingsOf(const Model& model) {
  std::vector<Request> requests{Request::setFriction(model.scene.friction)};
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
      loaded_(settingsOf(model)),
      friction_(physics.state().live.friction) {}

LiveSettings::Answer LiveSettings::apply(const Request& request) {
  if (request.kind == Request::Kind::SetFriction) return setFriction(request.value);
  if (request.kind == Request::Kind::SetMaterial) return setMaterial(request.index, request.material);
  return {};
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
