#pragma once

#include "simulation/model.h"
#include "simulation/state.h"
#include "simulation/workspace.h"

namespace palpate {

/// What the loop drives, one call a tick; TissuePhysics is the real one, tests have
/// theirs. All but the constructor and stateHash is real-time: no allocation, no lock, no throw.
class Physics {
 public:
  virtual ~Physics() = default;
  /// Where command.stop cuts the tick short, the report says so and the state is that of before.
  virtual StepReport tick(const Command& command) = 0;
  virtual const State& state() const = 0;
  virtual std::uint64_t stateHash() const = 0;
  /// The freshly loaded state, bit for bit, but for friction, materials and loads: these stay as they were set.
  virtual void reset() = 0;
  /// An earlier state of this physics, with zero velocity; friction and materials stay as they were set.
  virtual void restore(const State& past) = 0;
  virtual void setFriction(double coefficient) = 0;
  /// From the next step on. Physics without tissue has none.
  virtual void setLoads(const LiveLoads&) {}
  /// Replaces a material from the next step on. Returns 0 when done; where it is
  /// stiffer than dt is stable for, changes nothing and returns the factor (> 1) by
  /// which it is too stiff.
  virtual double setMaterial(int index, const Material& material) = 0;
};

/// A model, its state and its workspace.
class TissuePhysics final : public Physics {
 public:
  /// @param model  must outlive this; several may share it, and none changes it
  /// @param threads  physics threads, the loop's own included
  TissuePhysics(const Model& model, int threads);

  StepReport tick(const Command& command) override;
  const State& state() const override { return state_; }
  std::uint64_t stateHash() const override;
  void reset() override;
  void restore(const State& past) override;
  /// Puts in a state of this model as it is, live settings included.
  void putIn(const State& state);
  /// What setMaterial would return, without doing it. Any thread.
  double excessOf(int index, const Material& material) const;
  void setFriction(double coefficient) override;
  void setLoads(const LiveLoads& loads) override { state_.live.loads = loads; }
  double setMaterial(int index, const Material& material) override;

  SpinTeam& team() { return workspace_.team; }
  /// Of each boundary on the tissue in the last step; 0 before the first, and after reset, restore and putIn.
  const std::vector<Reaction>& reactions() const { return workspace_.boundary.reaction; }

 private:
  void forgetLastTick();

  const Model& model_;
  State initial_;  // at rest, with the live settings in force
  State state_;
  State before_;  // the present tick, where that is long enough to be cut short; else empty
  Workspace workspace_;
  double allowed_stiffening_;  // of a material over the loaded one
};

}  // namespace palpate
