#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "app/panels/tool_choice.h"
#include "mechanics/materials/material.h"

namespace palpate::app {

/// What a file is opened as.
enum class OpenKind { Scene, Script, Recording, Curve };

/// One thing that the user asks for, by a key, a button or a menu's line: Viewer::carryOut does it.
struct UserAction {
  // clang-format off
  enum Kind {
    // The run. Reset keeps friction and materials, ResetAll does not; LookAt shows the picture at `value` s.
    TogglePause, SingleStep, Reset, ResetAll, RestartScript, Undo, DismissNotice, LookAt, LookNow,
    // The probe. Press goes as deep as is set, OpenJaws `value` m apart; SetGlide: 1 over the skin, 0 freely. The next
    // three choose another one, for UseProbe.
    Press, Lift, Grasp, OpenJaws, ToStart, Upright, SetGlide, NextShape, Larger, Smaller,
    // The tissue, by `value`: the coefficient, or the index of the `material`.
    SetFriction, SetMaterial,
    // The search. NextHardness is of the next mark.
    NextHardness, Mark, Unmark, Submit,
    // The view. ShowColours: `value` is the ColourMap.
    FrameView, ShowColours, ToggleNodes, TogglePoints, ToggleGhost, ToggleSection, CutThroughTool, TogglePanels,
    ToggleEngineer, ToggleHelp, ToggleTimeline, ToggleFullScreen, ToggleDemo, Close,
    // Files. AskForFile: `value` is the OpenKind; LayCurve lays `file` over the force.
    AskForFile, LayCurve, SavePicture, SaveForces, SavePresses, SaveState, SaveRecording, ClearPresses,
    // What leaves the session, for `file`, for the same scene with `tool`, or for the same search; in this order where
    // a frame asks for several: a scene before the script that is dropped with it. Leave: what is at stake may be lost.
    OpenScene, OpenScript, OpenRecording, UseProbe, SearchAgain, Quit, Leave
  };
  // clang-format on

  Kind kind;
  double value = 0;
  std::string file{};
  ToolChoice tool{};
  Material material{};
};

using UserActions = std::vector<UserAction>;

inline bool asks(const UserActions& actions, UserAction::Kind kind) {
  return std::any_of(actions.begin(), actions.end(), [=](const UserAction& action) { return action.kind == kind; });
}

}  // namespace palpate::app
