// What must be said over the view: the tissue gave up, the pull's force, the demo's large number.
#include <imgui.h>

#include <algorithm>

#include "app/panels/panels.h"
#include "app/panels/widgets.h"

namespace palpate::app {

void drawNotice(const Theme& theme, const PanelData& data, const Rect& view, PanelRequests& requests) {
  const float s = theme.scale;
  const bool frozen = data.snapshot.status.frozen;
  const float width = std::min(view.width - 20 * s, 470 * s);
  ImGui::SetNextWindowPos({view.x + 0.5F * (view.width - width), view.y + 10 * s}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({width, 0}, ImGuiCond_Always);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, frozen ? colours::frozen_banner : colours::notice_banner);
  if (ImGui::Begin(frozen ? "##frozen" : "##notice", nullptr,
                   ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                       ImGuiWindowFlags_NoFocusOnAppearing)) {
    ImGui::PushTextWrapPos(0);
    const bool told = data.notice && (data.notice->frozen || !frozen);
    ImGui::TextUnformatted(told ? data.notice->sentence.c_str() : "The tissue stands still.");
    ImGui::PopTextWrapPos();
    ImGui::Spacing();
    const bool by_hand = data.driver == ToolDriver::User;
    if (button("Undo 2 s", 84 * s, by_hand, "a script or recording moves the probe: reset begins it again"))
      requests.undo_more = true;
    ImGui::SameLine();
    if (button("Reset", 66 * s)) requests.reset = true;
    if (!frozen) {
      ImGui::SameLine();
      if (button("Go on", 66 * s)) requests.dismiss_notice = true;
    }
    const std::string& details = told ? data.notice->details : data.frozen_reason;
    if (!details.empty()) {
      ImGui::SameLine(0, 16 * s);
      ImGui::PushFont(theme.small);
      const bool open = ImGui::TreeNodeEx("Details", ImGuiTreeNodeFlags_NoTreePushOnOpen);
      if (open) note(theme, details, colours::text);
      ImGui::PopFont();
    }
  }
  ImGui::End();
  ImGui::PopStyleColor();
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

/// The force so large that it is read from the back of a room.
void drawDemoForce(const Theme& theme, const PanelData& data) {
  const float s = theme.scale, size = 3.2F * theme.big->FontSize;
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  const ForceSample& force = data.force.sample;
  const std::string number = format("%.2f N", force.force_filtered.norm());
  const std::string depth = force.depth_m > 0 ? format("%.1f mm deep", 1e3 * force.depth_m) : std::string("in air");
  const ImVec2 extent = theme.big->CalcTextSizeA(size, FLT_MAX, 0, number.c_str());
  const ImVec2 at{screen.x - extent.x - 30 * s, screen.y - extent.y - 62 * s};
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  draw->AddRectFilled({at.x - 18 * s, at.y - 8 * s}, {screen.x - 12 * s, screen.y - 12 * s}, IM_COL32(22, 26, 32, 190),
                      12 * s);
  const ImU32 colour = !data.force.fresh            ? colours::stale
                       : force.doubt != Doubt::None ? colours::warning
                                                    : colours::accent;
  draw->AddText(theme.big, size, at, colour, number.c_str());
  draw->AddText(theme.big, theme.big->FontSize, {at.x, at.y + extent.y}, colours::text, depth.c_str());
}

}  // namespace palpate::app
