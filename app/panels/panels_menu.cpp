// The File menu and its dialogs.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>

#include "app/panels/panels.h"
#include "app/panels/widgets.h"

namespace palpate::app {

namespace {

constexpr ImGuiWindowFlags dialog_flags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                          ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize |
                                          ImGuiWindowFlags_NoSavedSettings;

struct OpenWords {
  const char *title, *hint;
};
constexpr OpenWords open_words[] = {{"Open a scene", "or a scene's file"},
                                    {"Open a tool script", "a script's file, or indent_hold_retract"},
                                    {"Replay a recording", "a file that was saved as a recording, .rec"},
                                    {"Lay a curve over the force", "CSV with the columns depth_mm and force_N"}};

void beginDialog(const Theme& theme, const char* name, const char* title) {
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  const float s = theme.scale;
  ImGui::SetNextWindowPos({0.5F * screen.x, 0.5F * screen.y}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({std::min(420 * s, screen.x - 20 * s), 0},
                                      {screen.x - 20 * s, screen.y - 20 * s});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {18 * s, 14 * s});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::SetNextWindowFocus();  // above what was folded out since
  ImGui::Begin(name, nullptr, dialog_flags);
  ImGui::PushFont(theme.title);
  ImGui::TextUnformatted(title);
  ImGui::PopFont();
  ImGui::Spacing();
}

void endDialog() {
  ImGui::End();
  ImGui::PopStyleVar();
}

}  // namespace

void drawFileMenu(const Theme& theme, const PanelData& data, PanelState& state, UserActions& asked) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {10 * theme.scale, 8 * theme.scale});
  if (ImGui::BeginPopup("##file")) {
    const auto open = [&](OpenKind kind) { asked.push_back({UserAction::AskForFile, static_cast<double>(kind)}); };
    if (ImGui::MenuItem("Open scene ...", "Ctrl+O")) open(OpenKind::Scene);
    if (ImGui::MenuItem("Open tool script ...")) open(OpenKind::Script);
    if (ImGui::MenuItem("Replay a recording ...")) open(OpenKind::Recording);
    if (ImGui::MenuItem("Lay a curve over the force ...")) open(OpenKind::Curve);
    ImGui::Separator();
    if (ImGui::MenuItem("Look back over the last minute", "T", state.timeline_shown))
      asked.push_back({UserAction::ToggleTimeline});
    if (ImGui::MenuItem("Save the run as a recording")) asked.push_back({UserAction::SaveRecording});
    if (ImGui::MenuItem("Save picture", "F12")) asked.push_back({UserAction::SavePicture});
    if (ImGui::MenuItem("Save force as CSV", "Ctrl+S")) asked.push_back({UserAction::SaveForces});
    if (ImGui::MenuItem("Save force-depth curves")) asked.push_back({UserAction::SavePresses});
    if (ImGui::MenuItem("Save the tissue's state (VTU)", nullptr, false, !data.searching()))
      asked.push_back({UserAction::SaveState});
    if (data.searching() && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
      ImGui::SetTooltip("it shows where the lumps are: once the answers are in");
    ImGui::Separator();
    if (ImGui::MenuItem("Engineer's numbers", "E", state.engineer)) asked.push_back({UserAction::ToggleEngineer});
    if (ImGui::MenuItem("Full screen", "F11")) asked.push_back({UserAction::ToggleFullScreen});
    if (ImGui::MenuItem("Demo: large force, no panels", "F10")) asked.push_back({UserAction::ToggleDemo});
    ImGui::Separator();
    if (ImGui::MenuItem("Quit", "Esc")) asked.push_back({UserAction::Quit});
    ImGui::EndPopup();
  }
  ImGui::PopStyleVar();
}

void drawOpenDialog(const Theme& theme, const PanelData& data, PanelState& state, UserActions& asked) {
  const float s = theme.scale;
  const OpenWords& words = open_words[static_cast<std::size_t>(state.open_kind)];
  beginDialog(theme, "##open", words.title);
  std::string chosen;
  if (state.open_kind == OpenKind::Scene) {
    ImGui::BeginChild("##scenes", {400 * s, 190 * s}, true);
    for (const std::string& scene : data.scenes)
      if (ImGui::Selectable(scene.c_str())) chosen = scene;
    ImGui::EndChild();
  }
  std::array<char, 1024> typed{};
  std::strncpy(typed.data(), state.path.c_str(), typed.size() - 1);
  ImGui::SetNextItemWidth(400 * s);
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  const bool enter =
      ImGui::InputTextWithHint("##path", words.hint, typed.data(), typed.size(), ImGuiInputTextFlags_EnterReturnsTrue);
  state.path = typed.data();
  if (button("Open", 90 * s, !state.path.empty(), "type the path of a file, or choose above") ||
      (enter && !state.path.empty()))
    chosen = state.path;
  ImGui::SameLine();
  if (button("Cancel", 90 * s)) state.open_shown = false;
  note(theme, "A file can also be dropped on the window.");
  if (!chosen.empty()) {
    constexpr UserAction::Kind opening[] = {UserAction::OpenScene, UserAction::OpenScript, UserAction::OpenRecording,
                                            UserAction::LayCurve};
    asked.push_back({opening[static_cast<std::size_t>(state.open_kind)], 0, chosen});
    state.open_shown = false;
  }
  endDialog();
}

void drawProblem(const Theme& theme, PanelState& state) {
  beginDialog(theme, "##problem", "That did not work");
  ImGui::PushTextWrapPos(0.9F * ImGui::GetIO().DisplaySize.x);
  ImGui::TextUnformatted(state.problem.c_str());
  ImGui::PopTextWrapPos();
  note(theme, "The scene that was open goes on.");
  ImGui::Spacing();
  if (button("Close", 90 * theme.scale)) state.problem.clear();
  endDialog();
}

void drawQuitDialog(const Theme& theme, PanelState& state, UserActions& asked) {
  const float s = theme.scale;
  beginDialog(theme, "##quit", "Leave now?");
  ImGui::TextUnformatted(state.at_stake.c_str());
  ImGui::Spacing();
  if (button("Leave", 90 * s)) asked.push_back({UserAction::Leave});
  ImGui::SameLine();
  if (button("Stay", 90 * s)) state.at_stake.clear();
  endDialog();
}

}  // namespace palpate::app
