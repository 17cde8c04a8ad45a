#pragma once

#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

/// solveToolContacts with tools that give way to more than their max_force (Model::max_tool_force), as the hand that
/// holds them would: at the limit it pushes no harder, however the tissue moves.
///
///   x_tool = wanted + t out,   out = F / |F| of the tool at `wanted`,   |F(t)| = max_force,   t >= 0
///
/// Jaws open likewise until the pinch is within their grip_force. t is searched within the step, by contacts solved
/// anew with the tool elsewhere (eight times at most), to 0.85 .. 1 of the limit. A tool that is shut in, with walls on
/// its way out, too, goes by the force it feels at each place to the one with the least (six times more). It goes back
/// four times as fast as it may follow a hand at most. Below the limit all is as without it, bit for bit.
///
/// @param tools  where they should be at the step's end; receives where they are
/// @return the force on the first tool, N
/// Real-time: no allocation, no lock, no throw. Test: simulation/yielding_contacts_test.cpp
Vec3 solveYieldingContacts(const Model& model, double alpha, const float* inverse_mass, ToolPostures& tools,
                           State& state, ToolLoads& loads);

/// How far the tools stay behind where they should be: what one step leaves to the next ones of a tick.
class StayedBehind {
 public:
  /// Shifts postures by it.
  void shift(ToolPostures& tools) const;
  /// A step was to bring the tools to `wanted`, and the state has where they are.
  void add(const Model& model, const ToolPostures& wanted, const State& state);

 private:
  bool any_ = false;
  std::array<Vec3, max_tools> way_ = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // m
  std::array<double, max_tools> opening_{};                                                     // m
};

}  // namespace palpate
