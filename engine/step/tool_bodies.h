#pragma once

#include "contact/contact.h"
#include "model/model.h"
#include "model/state.h"

namespace palpate {

struct ContactWorkspace;

// The tools of a model one by one. Real-time: no allocation, no lock, no throw. Test: simulation/tool_bodies_test.cpp

/// The command under which every tool is where it starts.
Command restCommand(const Model& model);

/// Where they are.
ToolPostures posturesOf(const State& state);

/// A share of the way between two, turning and closing included.
ToolPosture between(const ToolPosture& from, const ToolPosture& to, double share);

/// Bound on how far any point of a tool's bodies goes between two postures, m.
double largestWay(const Model& model, int tool, const ToolPosture& from, const ToolPosture& to);

/// How the tools should go in one tick: each evenly from where it is to where the command wants it, no faster than its
/// scene allows, turning and closing included, but where a rigid body pushes it.
class ToolWays {
 public:
  ToolWays(const Model& model, const State& state, const Command& command);

  /// Where they should be at the tick's end.
  const ToolPostures& end() const { return to_; }

  /// Whether a tool stands before what is rigid instead (RigidStop).
  bool stopped(int tool) const { return stopped_[static_cast<std::size_t>(tool)]; }

  /// Whether it is in a rigid body all the same.
  bool fails(int tool) const { return fails_[static_cast<std::size_t>(tool)]; }

  /// Where they should be after the next of `left` steps of the tick, from where they are: a tool that gave way tries
  /// to make it good.
  ToolPostures next(const State& state, int left) const;

  /// m, that a body may go in the tick.
  double reach(const ToolBody& body) const { return reach_[static_cast<std::size_t>(body.tool)]; }

 private:
  const Model& model_;
  int count_;
  ToolPostures to_;
  std::array<bool, max_tools> stopped_{}, fails_{};
  std::array<double, max_tools> reach_{};  // m
};

/// Adds what a body felt in solveContacts to its tool's.
void addToLoad(const ToolBody& body, const TouchingTool& felt, ToolLoads& loads);

/// solveContacts for all that a model's skin touches in a step. Tools go from where the state has them to `tools`, or
/// less far where the tissue would push harder than their max_force, or pinch harder than their grip_force (ToolHold).
/// @param held   as Touching::held
/// @param tools  where they should be at the step's end; receives where they are
/// @param loads  receives force, pinch and contact count of each
ContactForces solveContacts(const Model& model, ToolPostures& tools, double alpha, const float* inverse_mass,
                            ContactGroup* held, State& state, ContactWorkspace& scratch, ToolLoads& loads);

}  // namespace palpate
