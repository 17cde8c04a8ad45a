#pragma once

#include "simulation/model.h"
#include "simulation/state.h"
#include "simulation/workspace.h"

namespace palpate::tools {

/// Ticks written by hand of only the passes that a neo-Hookean body without node patches needs: forces from a kernel
/// that knows
/// nothing else (barePassesFor), central difference, imposed nodes, watched energy. What simulation/step.cpp is held
/// to where a
/// scene uses no more than that. One thread.
/// Test: tools/bench_features_test.cpp (as tick() but for rounding)
class BareLoop {
 public:
  enum class Contact { None, Frictionless };

  /// @param model      neo-Hookean, without node patches
  /// @param workspace  of one thread; both outlive the loop
  BareLoop(const Model& model, Workspace& workspace, const State& start, Contact contact);

  /// With the tool held where it is.
  StepReport tick();
  const State& state() const { return state_; }

 private:
  StepReport step();

  const Model& model_;
  State state_;
  Workspace& workspace_;
  Contact contact_;
  const KernelPasses<float>* passes_ = nullptr;
};

}  // namespace palpate::tools
