#pragma once

#include "contact/contact.h"
#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

// The tools of a model one by one, whether it has one (State::tool_pose, State::contact) or several (State::more).
// Real-time unless said otherwise: no allocation, no lock, no throw. Test: simulation/tool_bodies_test.cpp

/// What a scene's tools make of a model: where each starts, how far it is from the skin, its bodies. For set-up; leaves
/// it empty where the one tool is one body.
/// Throws InputError where a tool starts inside the organ.
class SurfaceTree;
ToolSet makeToolSet(const Scene& scene, const SurfaceTree& organ, const TriangleSurface& skin);

/// The memory that a state has for them. For set-up.
MoreTools makeMoreTools(const Model& model);

/// The command under which every tool is where it starts.
Command restCommand(const Model& model);

/// Where tool k starts; where it is.
ToolPosture startOf(const Model& model, int tool);
ToolPosture postureOf(const State& state, int tool);
ToolPostures posturesOf(const Model& model, const State& state);
void setPostures(const Model& model, const ToolPostures& postures, State& state);

/// A share of the way between two, turning and closing included.
ToolPosture between(const ToolPosture& from, const ToolPosture& to, double share);

inline const ContactState& contactOf(const State& state, int body) {
  return body == 0 ? state.contact : state.more.contact[static_cast<std::size_t>(body - 1)];
}
inline ContactState& contactOf(State& state, int body) {
  return body == 0 ? state.contact : state.more.contact[static_cast<std::size_t>(body - 1)];
}

/// Body b and where it is when the tools are there.
ToolBody toolBody(const Model& model, int body);

/// How the tools should go in one tick: each evenly from where it is to where the command wants it, no faster than its
/// scene allows, turning and closing included.
class ToolWays {
 public:
  ToolWays(const Model& model, const State& state, const Command& command);

  /// Where they should be at the tick's end.
  const ToolPostures& end() const { return to_; }

  /// Where they should be after the next of `left` steps of the tick, from where they are: a tool that gave way tries
  /// to make it good.
  ToolPostures next(const State& state, int left) const;

  /// m, that body b may go in the tick.
  double reach(int body) const;

 private:
  const Model& model_;
  int count_;
  ToolPostures to_;
};

/// Adds what a body felt in solveContacts to its tool's.
void addToLoad(const ToolBody& body, const TouchingTool& felt, ToolLoads& loads);

/// solveContacts for all bodies, which go from where the state has them to `tools`, or less far where the tissue would
/// push harder than their max_force, or pinch harder than their grip_force (ToolHold).
/// @param tools  where they should be at the step's end; receives where they are
/// @param loads  receives force, pinch and contact count of each tool where there are several or jaws
/// @return the force on the first tool, N
Vec3 solveToolContacts(const Model& model, ToolPostures& tools, double alpha, const float* inverse_mass,
                       State& state, ToolLoads& loads);

}  // namespace palpate
