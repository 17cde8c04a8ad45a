// The last minute, to look back at.
#include <imgui.h>

#include <algorithm>

#include "app/panels/panels.h"
#include "app/panels/widgets.h"

namespace palpate::app {

void drawTimeline(const Theme& theme, const PanelData& data, const Rect& view, PanelState& state, UserActions& asked) {
  const float s = theme.scale;
  const TimelineView& time = *data.timeline;
  const float width = std::min(view.width - 20 * s, 620 * s), height = 62 * s;
  const float legend = data.colour_scale.map == ColourMap::Tissue ? 0 : 66 * s;  // which stands at the same place
  ImGui::SetNextWindowPos({view.x + 0.5F * (view.width - width), view.bottom() - legend - 10 * s}, ImGuiCond_Always,
                          {0, 1});
  ImGui::SetNextWindowSize({width, height}, ImGuiCond_Always);
  if (ImGui::Begin("##timeline", nullptr,
                   ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                       ImGuiWindowFlags_NoFocusOnAppearing)) {
    auto back = static_cast<float>(time.shown_s - time.now_s);
    const auto furthest = static_cast<float>(std::min(time.begin_s - time.now_s, -0.2));
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - 60 * s);
    if (ImGui::SliderFloat("##back", &back, furthest, 0, "##%.1f s", ImGuiSliderFlags_AlwaysClamp)) {
      state.timeline_plays = false;
      asked.push_back({UserAction::LookAt, time.now_s + static_cast<double>(back)});
    }
    ImGui::SameLine();
    ImGui::TextUnformatted(back < -0.05F ? format("%.1f s", static_cast<double>(back)).c_str() : "now");
    const float part = (ImGui::GetContentRegionAvail().x - 3 * ImGui::GetStyle().ItemSpacing.x) / 4;
    if (button(state.timeline_plays ? "Stop" : "Play", part, time.past, "first look back with the bar above"))
      state.timeline_plays = !state.timeline_plays;
    ImGui::SameLine();
    if (button("Now", part, time.past, "this is the present picture")) asked.push_back({UserAction::LookNow});
    ImGui::SameLine();
    if (button("Save run", part)) asked.push_back({UserAction::SaveRecording});
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("the whole run as a recording, which can be replayed bit for bit");
    ImGui::SameLine();
    if (button("Hide (T)", part)) asked.push_back({UserAction::ToggleTimeline});
    if (state.timeline_plays && time.past) {
      const double next = time.shown_s + static_cast<double>(ImGui::GetIO().DeltaTime);
      if (next < time.now_s)
        asked.push_back({UserAction::LookAt, next});
      else
        asked.push_back({UserAction::LookNow});
    }
  }
  ImGui::End();
}

}  // namespace palpate::app
