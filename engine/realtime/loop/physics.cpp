#include "realtime/loop/physics.h"

#include <algorithm>

#include "simulation/build_model.h"
#include "simulation/model_hash.h"
#include "simulation/step.h"

namespace palpate {
namespace {

// A material may be stiffened live until dt is this share of the critical step. The
// rest is for the stiffening by deformation; raise it and hard pokes may blow up.
constexpr double kLiveStepSafety = 0.75;

// A tick of more steps than this can be ended within, and keeps a copy of the state for it, which costs less than a
// step. Shorter ones are over before anybody waits.
constexpr int kLongTick = 64;

}  // namespace

TissuePhysics::TissuePhysics(const Model& model, int threads)
    : model_(model), initial_(initialState(model)), state_(initial_), workspace_(model, threads) {
  if (model.substeps_per_tick > kLongTick) before_ = initial_;
  // The critical step goes with 1 / sqrt(stiffness). Which material set it is not known, so each is taken for the one.
  const double ratio = kLiveStepSafety * model.dt_critical / model.dt;
  allowed_stiffening_ = std::max(ratio * ratio, 1.0);
}

StepReport TissuePhysics::tick(const Command& command) {
  if (model_.substeps_per_tick <= kLongTick) {
    Command whole = command;
    whole.stop = nullptr;
    return palpate::tick(model_, state_, whole, workspace_);
  }
  before_ = state_;  // same sizes: no allocation
  const StepReport report = palpate::tick(model_, state_, command, workspace_);
  if (report.cut_short) state_ = before_;
  return report;
}

std::uint64_t TissuePhysics::stateHash() const { return palpate::stateHash(model_, state_); }

// Same sizes: the vectors' copies go into the memory that they have.
void TissuePhysics::reset() {
  initial_.live = state_.live;
  state_ = initial_;
  forgetLastTick();
}

void TissuePhysics::putIn(const State& state) {
  state_ = state;
  forgetLastTick();
}

void TissuePhysics::forgetLastTick() {
  workspace_.resolution.restart();
  std::vector<Reaction>& reactions = workspace_.boundary.reaction;
  std::fill(reactions.begin(), reactions.end(), Reaction{});
}

void TissuePhysics::restore(const State& past) {
  initial_.live = state_.live;
  state_ = past;
  state_.live = initial_.live;
  std::fill(state_.du.begin(), state_.du.end(), Float4{});
  state_.energy.fresh = true;  // its kinetic energy is gone
  forgetLastTick();
}

void TissuePhysics::setFriction(double coefficient) { state_.live.friction = coefficient; }

double TissuePhysics::excessOf(int index, const Material& material) const {
  const Material& loaded = model_.materials[static_cast<std::size_t>(index)];
  const double excess = stiffening(loaded, material) / allowed_stiffening_;
  return excess > 1 ? excess : 0;
}

double TissuePhysics::setMaterial(int index, const Material& material) {
  if (const double excess = excessOf(index, material); excess > 0) return excess;
  palpate::setMaterial(model_, index, material, state_.live);
  state_.energy.fresh = true;
  return 0;
}

}  // namespace palpate
