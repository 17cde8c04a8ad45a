// What must be said over the view: the tissue gave up, the pull's force, the demo's large number.
#include <imgui.h>

#include <algorithm>

#include "app/panels/panels.h"
#include "app/panels/widgets.h"

namespace palpate::app {

namespace {
constexpr float large_notice =
    1.8F;  // times the size of one beside panels: the demo's, to be read from some steps away
}

void drawNotice(const Theme& theme, const PanelData& data, const Rect& view, bool large, UserActions& asked) {
  const float s = theme.scale * (large ? large_notice : 1);
  const bool frozen = data.snapshot.status.frozen;
  const float width = std::min(view.width - 20 * s, 470 * s);
  const float x = view.x + 0.5F * (view.width - width);
  if (large)  // at the foot, where no tool's handle is
    ImGui::SetNextWindowPos({x, view.bottom() - 10 * s}, ImGuiCond_Always, {0, 1});
  else
    ImGui::SetNextWindowPos({x, view.y + 10 * s}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({width, 0}, ImGuiCond_Always);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, frozen ? colours::frozen_banner : colours::notice_banner);
  if (ImGui::Begin(frozen ? "##frozen" : "##notice", nullptr,
                   ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                       ImGuiWindowFlags_NoFocusOnAppearing)) {
    ImGui::PushFont(large ? theme.large : theme.body);
    ImGui::PushTextWrapPos(0);
    const bool told = data.notice && (data.notice->frozen || !frozen);
    ImGui::TextUnformatted(told ? data.notice->sentence.c_str() : "The tissue stands still.");
    ImGui::PopTextWrapPos();
    ImGui::Spacing();
    const bool by_hand = data.driver == ToolDriver::User;
    if (undoButton(66 * s, by_hand)) asked.push_back({UserAction::Undo});
    ImGui::SameLine();
    if (button("Reset", 66 * s)) asked.push_back({UserAction::Reset});
    if (!frozen) {
      ImGui::SameLine();
      if (button("Go on", 66 * s)) asked.push_back({UserAction::DismissNotice});
    }
    const std::string& details = told ? data.notice->details : data.frozen_reason;
    if (!details.empty()) {
      ImGui::SameLine(0, 16 * s);
      ImGui::PushFont(theme.small);
      const bool open = ImGui::TreeNodeEx("Details", ImGuiTreeNodeFlags_NoTreePushOnOpen);
      if (open) note(theme, details, colours::text);
      ImGui::PopFont();
    }
    ImGui::PopFont();
  }
  ImGui::End();
  ImGui::PopStyleColor();
}

bool drawCall(const Theme& theme, const char* sentence, const Rect& view) {
  ImGui::SetNextWindowPos({view.x + 0.5F * view.width, view.y + 0.5F * view.height}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::PushFont(theme.large);
  const bool fits = ImGui::CalcTextSize(sentence).x < view.width - 60 * theme.scale;
  if (!fits) ImGui::PopFont();
  ImGui::Begin("##call", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize);
  const bool clicked = button(sentence, 0);
  ImGui::End();
  if (fits) ImGui::PopFont();
  return clicked;
}

void drawPullForce(const Theme& theme, const PanelData& data) {
  if (data.pull_N < 0) return;
  const std::string text = format("%.2f N", data.pull_N);
  ImGui::PushFont(theme.title);
  const ImVec2 size = ImGui::CalcTextSize(text.c_str()), mouse = ImGui::GetIO().MousePos;
  const float s = theme.scale;
  const ImVec2 at{mouse.x + 16 * s, mouse.y - 10 * s - size.y};
  ImDrawList* draw = ImGui::GetForegroundDrawList();
  draw->AddRectFilled({at.x - 6 * s, at.y - 3 * s}, {at.x + size.x + 6 * s, at.y + size.y + 3 * s},
                      IM_COL32(22, 26, 32, 220), 6 * s);
  draw->AddText(at, colours::good, text.c_str());
  ImGui::PopFont();
}

namespace {
float demoSize(const Theme& theme) {
  return std::min(3.2F * theme.big->FontSize, 0.13F * ImGui::GetIO().DisplaySize.x);
}
std::string demoNumber(const PanelData& data) {
  return format("%.2f N", data.pull_N >= 0 ? data.pull_N : data.force.sample.force_filtered.norm());
}
std::string demoDepth(const PanelData& data) {
  if (data.pull_N >= 0) return "pull on the tissue";
  const double depth = data.force.sample.depth_m;
  return depth > 0 ? format("%.1f mm deep", 1e3 * depth) : std::string("in air");
}
}  // namespace

Rect demoForcePlace(const Theme& theme, const PanelData& data) {
  const float s = theme.scale, size = demoSize(theme);
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  const float number = theme.big->CalcTextSizeA(size, FLT_MAX, 0, demoNumber(data).c_str()).x;
  const float depth = theme.big->CalcTextSizeA(theme.big->FontSize, FLT_MAX, 0, demoDepth(data).c_str()).x;
  const float width = std::max(number, depth) + 36 * s, height = size + 58 * s;
  return {screen.x - width - 12 * s, screen.y - height - 12 * s, width, height};
}

Rect besideDemoForce(const Rect& view, const Rect& force, float scale) {
  constexpr float least_width = 300;  // px at scale 1, of the timeline's buttons
  Rect rest = view;
  if (force.x - view.x >= least_width * scale)
    rest.width = force.x - view.x;
  else
    rest.height = std::max(1.0F, force.y - view.y);
  return rest;
}

void drawInvitation(const Theme& theme, const Rect& view) {
  const std::string text =
      fitted("Click the organ to press it yourself", std::max(1.0F, view.width - 48 * theme.scale));
  ImGui::GetBackgroundDrawList()->AddText(theme.large, theme.large->FontSize,
                                          {view.x + 24 * theme.scale, view.bottom() - 48 * theme.scale}, colours::text,
                                          text.c_str());
}

/// The force so large that it is read from the back of a room.
void drawDemoForce(const Theme& theme, const PanelData& data) {
  const float s = theme.scale, size = demoSize(theme);
  const ForceSample& force = data.force.sample;
  const std::string number = demoNumber(data);
  const Rect place = demoForcePlace(theme, data);
  const ImVec2 at{place.x + 18 * s, place.y + 8 * s};
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  draw->AddRectFilled({place.x, place.y}, {place.right(), place.bottom()}, IM_COL32(22, 26, 32, 190), 12 * s);
  const ImU32 colour = data.pull_N >= 0                  ? colours::good
                       : !data.force.fresh               ? colours::stale
                       : force.doubt > Doubt::Resolution ? colours::warning
                                                         : colours::accent;
  draw->AddText(theme.big, size, at, colour, number.c_str());
  draw->AddText(theme.big, theme.big->FontSize, {at.x, at.y + size}, colours::text, demoDepth(data).c_str());
}

}  // namespace palpate::app
