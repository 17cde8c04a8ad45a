#include "realtime/loop/physics.h"

#include <algorithm>

#include "simulation/build_model.h"
#include "simulation/step.h"

namespace palpate {
namespace {

// A material may be stiffened live until dt is this share of the critical step. The
// rest is for the stiffening by deformation; raise it and hard pokes may blow up.
constexpr double kLiveStepSafety = 0.75;

}  // namespace

TissuePhysics::TissuePhysics(Model& model, int threads)
    : model_(model), initial_(initialState(model)), state_(initial_), workspace_(model, threads) {
  // The critical step goes with 1 / sqrt(wave modulus). Which material set it is not
  // known, so each is taken for the one.
  const double ratio = kLiveStepSafety * model.dt_critical / model.dt;
  for (const Material& material : model.materials) {
    allowed_wave_modulus_.push_back(material.waveModulus() * (ratio > 1 ? ratio * ratio : 1.0));
  }
}

StepReport TissuePhysics::tick(const Command& command) { return palpate::tick(model_, state_, command, workspace_); }

std::uint64_t TissuePhysics::stateHash() const { return palpate::stateHash(state_); }

// Same sizes: the vectors' copies go into the memory that they have.
void TissuePhysics::reset() { state_ = initial_; }

void TissuePhysics::setFriction(double coefficient) { model_.scene.friction = coefficient; }

double TissuePhysics::setMaterial(int index, const Material& material) {
  const auto m = static_cast<std::size_t>(index);
  // Bulk and shear stiffness each count: at one wave modulus one can be traded for the other, but node
  // patches relax only the bulk.
  const Material& loaded = model_.materials[m];
  const double allowed = allowed_wave_modulus_[m] / loaded.waveModulus();
  const double excess =
      std::max(material.bulk_modulus / loaded.bulk_modulus, material.shear_modulus / loaded.shear_modulus) / allowed;
  if (excess > 1) return excess;
  // The density is in the lumped masses, which stay.
  // model_.materials stays as loaded: other threads read it.
  model_.kernel.materials[m] = material;
  updatePatchBulk(model_.kernel);
  state_.energy.fresh = true;
  return 0;
}

}  // namespace palpate
