#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>

#include "model/model.h"
#include "model/state.h"
#include "setup/passage.h"
#include "step/workspace.h"

namespace palpate {

/// What the loop drives, one call a tick; TissuePhysics is the real one, tests have
/// theirs. All but the constructor and stateHash is real-time: no allocation, no lock, no throw.
class Physics {
 public:
  virtual ~Physics() = default;
  virtual StepReport tick(const Command& command) = 0;
  virtual const State& state() const = 0;
  virtual std::uint64_t stateHash() const = 0;
  /// The freshly loaded state, bit for bit, but for friction, materials and loads: these stay as they were set.
  virtual void reset() = 0;
  /// An earlier state of this physics, with zero velocity; friction and materials stay as they were set.
  virtual void restore(const State& past) = 0;
  virtual void setFriction(int tool, double coefficient) = 0;
  /// From the next step on. Physics without tissue has none.
  virtual void setLoads(const LiveLoads&) {}
  /// Replaces a material from the next step on. Returns 0 when done; where it is
  /// stiffer than dt is stable for, changes nothing and returns the factor (> 1) by
  /// which it is too stiff.
  virtual double setMaterial(int index, const Material& material) = 0;
};

/// A place of a cloud that follows the tool (setup/place.h), with the memory that its steps need.
struct ReadyPlace {
  ReadyPlace(std::shared_ptr<const Place> made, std::shared_ptr<SpinTeam> team)
      : shared(std::move(made)), workspace(place.model, std::move(team)) {}
  /// @param beside  of the same body, stepped by the same loop
  ReadyPlace(std::shared_ptr<const Place> made, const Workspace& beside)
      : shared(std::move(made)), workspace(place.model, beside.shared_team, beside.shared_contact) {}
  const std::shared_ptr<const Place> shared;  // with other loops
  const Place& place = *shared;
  Workspace workspace;
};

/// A place that is ready, and the way there from another.
struct PlaceChange {
  PlaceChange(std::shared_ptr<ReadyPlace> from, std::shared_ptr<ReadyPlace> to, const Places& places);
  std::shared_ptr<ReadyPlace> from, to;
  Passage passage;
  PassageScratch scratch;
  State state;  // of `to`, with room for any place
};

/// A model, its state and its workspace.
class TissuePhysics final : public Physics {
 public:
  /// @param model  must outlive this; several may share it, and none changes it
  /// @param threads  physics threads, the loop's own included
  TissuePhysics(const Model& model, int threads);

  /// Of a cloud that follows the tool. Places that it was at of late stay with it, so that it may go back to a state of
  /// them.
  /// @param start  where it begins, and where reset() goes
  TissuePhysics(const Places& places, std::shared_ptr<ReadyPlace> start);

  StepReport tick(const Command& command) override;
  const State& state() const override { return state_; }
  std::uint64_t stateHash() const override;
  void reset() override;
  /// Where the state's place does not stay with it any more, as reset().
  void restore(const State& past) override;
  /// Puts in a state of this model as it is, live settings included; of a cloud that follows, of a place that it holds.
  void putIn(const State& state);
  /// What setMaterial would return, without doing it. Any thread.
  double excessOf(int index, const Material& material) const;
  void setFriction(int tool, double coefficient) override;
  void setLoads(const LiveLoads& loads) override { state_.live.loads = loads; }
  double setMaterial(int index, const Material& material) override;

  /// Places that it holds beside the start, at most: those that it was at last.
  static constexpr std::size_t most_held = 4;
  /// Lets go of all but the start, the present one, and those that it may yet go back to. @param needed  (PlaceIndex)
  template <class Needed>
  void holdOnly(Needed needed) {
    for (auto held = held_.begin() + 1; held != held_.end(); ++held)
      if (*held && *held != place_ && !needed((*held)->place.index)) held->reset();
  }

  /// The present place; null where the cloud stays.
  const std::shared_ptr<ReadyPlace>& place() const { return place_; }
  /// Whether it may go back to a state of this place.
  bool holds(const PlaceIndex& index) const { return find(index) != nullptr; }
  /// Goes on at another place. @param change  from the present one; its memory is used up unless it stays
  /// @param most_rise  of the strain energy, as a share: where it rose by more while tissue is squeezed (mass is added
  /// to it), it stays as it is, and the change may be tried again: what is bent as only fine nodes bend is torn by
  /// coarse ones
  /// @return the place that it holds no longer for that, or no_place; nothing: it stays
  std::optional<PlaceIndex> goTo(PlaceChange& change, double most_rise = std::numeric_limits<double>::infinity());

  SpinTeam& team() { return *team_; }
  /// Of each boundary on the tissue in the last step; 0 before the first, and after reset, restore and putIn.
  const std::vector<Reaction>& reactions() const { return workspace_->boundary.reaction; }
  Vec3 pinForce(int vertex) const { return workspace_->pin_force.at(vertex); }  // N, likewise
  /// Of the present state (HoldingFriction), for its fields.
  const AlignedVector<float>& holdingFriction() {
    findHoldingFriction(*model_, state_, *workspace_);
    return workspace_->kernel.cell_volume.friction;
  }

 private:
  void prepare();
  void forgetLastTick();
  const std::shared_ptr<ReadyPlace>* find(const PlaceIndex& index) const;
  void moveTo(const std::shared_ptr<ReadyPlace>& place);

  // Where the cloud stays.
  std::unique_ptr<Workspace> own_workspace_;
  // Where it follows: the start, then those it was at, the last one first.
  std::array<std::shared_ptr<ReadyPlace>, 1 + most_held> held_;
  std::shared_ptr<ReadyPlace> place_;

  std::shared_ptr<SpinTeam> team_;
  const Model* model_;    // the present one
  Workspace* workspace_;  // its
  State initial_;         // at rest, with the live settings in force
  State state_;
  double allowed_stiffening_ = 1;  // of a material over the loaded one
};

}  // namespace palpate
