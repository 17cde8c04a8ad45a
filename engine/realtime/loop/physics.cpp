#include "realtime/loop/physics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mechanics/internal_forces.h"
#include "model/model_hash.h"
#include "setup/build_model.h"
#include "step/step.h"

namespace palpate {
namespace {

// A material may be stiffened live until dt is this share of the critical step. The
// rest is for the stiffening by deformation; raise it and hard pokes may blow up.
constexpr double kLiveStepSafety = 0.75;

}  // namespace

PlaceChange::PlaceChange(std::shared_ptr<ReadyPlace> a, std::shared_ptr<ReadyPlace> b, const Places& places)
    : from(std::move(a)),
      to(std::move(b)),
      passage(makePassage(from->place, to->place)),
      scratch(passage, from->place.node.size()),
      state(initialState(to->place.model)) {
  state.place = to->place.index;
  reserveForPlaces(places, state);
}

TissuePhysics::TissuePhysics(const Model& model, int threads)
    : own_workspace_(std::make_unique<Workspace>(model, threads)),
      team_(own_workspace_->shared_team),
      model_(&model),
      workspace_(own_workspace_.get()),
      initial_(initialState(model)) {
  prepare();
}

TissuePhysics::TissuePhysics(const Places& places, std::shared_ptr<ReadyPlace> start)
    : place_(std::move(start)),
      team_(place_->workspace.shared_team),
      model_(&place_->place.model),
      workspace_(&place_->workspace),
      initial_(initialState(*model_)) {
  held_[0] = place_;
  initial_.place = place_->place.index;
  reserveForPlaces(places, initial_);
  prepare();
}

void TissuePhysics::prepare() {
  state_ = initial_;
  reserveAs(initial_, state_);
  // The critical step goes with 1 / sqrt(stiffness). Which material set it is not known, so each is taken for the one.
  const double ratio = kLiveStepSafety * model_->dt_critical / model_->dt;
  allowed_stiffening_ = std::max(ratio * ratio, 1.0);
}

StepReport TissuePhysics::tick(const Command& command) { return palpate::tick(*model_, state_, command, *workspace_); }

std::uint64_t TissuePhysics::stateHash() const { return palpate::stateHash(*model_, state_); }

const std::shared_ptr<ReadyPlace>* TissuePhysics::find(const PlaceIndex& index) const {
  for (const auto& held : held_)
    if (held && held->place.index == index) return &held;
  return nullptr;
}

/// The model changes; the state is the caller's to change with it.
void TissuePhysics::moveTo(const std::shared_ptr<ReadyPlace>& place) {
  place_ = place;
  model_ = &place_->place.model;
  workspace_ = &place_->workspace;
}

std::optional<PlaceIndex> TissuePhysics::goTo(PlaceChange& change, double most_rise) {
  State& there = change.state;
  applyPassage(change.to->place, change.passage, std::move(state_), change.scratch, there, team_.get());
  // What is hardly squeezed is hardly bent between the nodes.
  if (std::isfinite(most_rise) && state_.local_mass.active) {
    const auto strainEnergy = [&](ReadyPlace& at, const State& state) {
      findHoldingFriction(at.place.model, there, at.workspace);
      return internalForces(at.place.model.kernel, state.live.kernel, state.u.data(), at.workspace.kernel, *team_)
          .strain_energy;
    };
    if (!(strainEnergy(*change.to, there) <= (1 + most_rise) * strainEnergy(*place_, state_))) {
      swapContacts(state_, there);
      return std::nullopt;
    }
  }
  std::swap(state_, there);
  const ResolutionWatch& before = workspace_->resolution;
  moveTo(change.to);
  forgetLastTick();
  workspace_->resolution.goOnFrom(before);
  if (place_ == held_[0]) return no_place;
  const auto begin = held_.begin() + 1, end = held_.end();
  auto at = std::find(begin, end, place_);
  PlaceIndex lost = no_place;
  if (at == end) at = std::find(begin, end, nullptr);
  if (at == end) {
    --at;
    lost = (*at)->place.index;
  }
  *at = place_;
  std::rotate(begin, at, at + 1);
  return lost;
}

// No larger than there is room for: the vectors' copies go into the memory that they have.
void TissuePhysics::reset() {
  if (held_[0]) {
    carryLive(held_[0]->place.model, state_.live, initial_.live);
    moveTo(held_[0]);
  } else {
    initial_.live = state_.live;
  }
  state_ = initial_;
  forgetLastTick();
}

void TissuePhysics::putIn(const State& state) {
  if (const auto* held = find(state.place)) moveTo(*held);
  state_ = state;
  forgetLastTick();
}

void TissuePhysics::forgetLastTick() {
  workspace_->resolution.restart();
  workspace_->depth = {};
  std::vector<Reaction>& reactions = workspace_->boundary.reaction;
  std::fill(reactions.begin(), reactions.end(), Reaction{});
  workspace_->pin_force = {};
}

void TissuePhysics::restore(const State& past) {
  const Model& left = *model_;
  if (place_) {
    const auto* held = find(past.place);
    if (held == nullptr) return reset();
    moveTo(*held);
  }
  // What is set live stays, with patches of the model that it goes back to.
  initial_.live = state_.live;
  state_ = past;
  if (model_ == &left)
    state_.live = initial_.live;
  else
    carryLive(*model_, initial_.live, state_.live);
  std::fill(state_.du.begin(), state_.du.end(), Float4{});
  state_.energy.fresh = true;  // its kinetic energy is gone
  forgetLastTick();
}

void TissuePhysics::setFriction(int tool, double coefficient) {
  state_.live.friction[static_cast<std::size_t>(tool)] = coefficient;
}

double TissuePhysics::excessOf(int index, const Material& material) const {
  const Material& loaded = model_->materials[static_cast<std::size_t>(index)];
  const double excess = stiffening(loaded, material) / allowed_stiffening_;
  return excess > 1 ? excess : 0;
}

double TissuePhysics::setMaterial(int index, const Material& material) {
  if (const double excess = excessOf(index, material); excess > 0) return excess;
  palpate::setMaterial(*model_, index, material, state_);
  state_.energy.fresh = true;
  return 0;
}

}  // namespace palpate
