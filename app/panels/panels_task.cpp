// The search for lumps: marks, answers, score.
#include <imgui.h>

#include <array>
#include <cstring>

#include "app/panels/panels.h"
#include "app/panels/widgets.h"

namespace palpate::app {

namespace {

void drawSheet(const TaskScore::Sheet& sheet) {
  row("Found", std::to_string(sheet.hits), sheet.hits > 0 ? colours::good : colours::text);
  row("Missed", std::to_string(sheet.misses), sheet.misses > 0 ? colours::warning : colours::text);
  row("False alarms", std::to_string(sheet.false_alarms), sheet.false_alarms > 0 ? colours::warning : colours::text);
  if (sheet.mean_error_mm) row("Off by", format("%.1f mm", *sheet.mean_error_mm));
  if (sheet.hits > 0)
    row("Hardness right", format("%d of %d", sheet.hardness_right, sheet.hits),
        sheet.hardness_right < sheet.hits ? colours::warning : colours::good);
  row("Time", format("%.0f s", sheet.seconds));
  row("Skin covered", format("%.0f %%", 100 * sheet.covered_share));
  row("Force", format("%.2f N mean, %.2f N peak", sheet.mean_force_N, sheet.peak_force_N));
  row("Above the limit", format("%.1f s", sheet.seconds_above_limit),
      sheet.seconds_above_limit > 0 ? colours::warning : colours::text,
      format("seconds with more than %.0f N", TaskScore::force_limit).c_str());
}

void drawTrainee(PanelState& state) {
  std::array<char, 128> typed{};
  std::strncpy(typed.data(), state.trainee.c_str(), typed.size() - 1);
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  if (ImGui::InputTextWithHint("##trainee", "your name, or nothing", typed.data(), typed.size()))
    state.trainee = typed.data();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("stands on the score sheet");
}

}  // namespace

void drawTaskCard(const Theme& theme, const PanelData& data, PanelState& state, View& view, UserActions& asked) {
  if (!beginCard(theme, "Find the lumps")) return;
  const TaskScore& task = *data.task;
  bool pressed = view.colour_map == ColourMap::Pressure;
  if (ImGui::Checkbox("Show where I pressed", &pressed)) {
    view.colour_map = pressed ? ColourMap::Pressure : ColourMap::Tissue;
    view.colour_auto = true;
  }
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("the largest pressure so far, on the skin");
  if (data.revealed) {
    const TaskScore::Sheet sheet = task.sheet();
    drawSheet(sheet);
    if (sheet.missed_too_light > 0)
      note(theme, "Lumps were missed where you pressed too lightly to reach them, or not at all.", colours::warning);
    note(theme, "Conditions: " + data.conditions);
    if (button("Search again", ImGui::GetContentRegionAvail().x)) asked.push_back({UserAction::SearchAgain});
    ImGui::Spacing();
    return;
  }
  row("Hidden / marked",
      format("%d / %d", static_cast<int>(task.lumps().size()), static_cast<int>(task.marks().size())));
  row("Time", format("%.0f s", task.seconds()));
  const bool by_recording = data.driver == ToolDriver::Replay;
  const char* const not_now = "the recording brings its own marks and answers";
  drawTrainee(state);
  for (int k = 1; k <= 3; ++k) {
    if (k > 1) ImGui::SameLine();
    ImGui::RadioButton(hardnessName(k), &state.hardness, k);
  }
  const float third = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  if (button("Mark (M)", third, !by_recording, not_now)) asked.push_back({UserAction::Mark});
  ImGui::SameLine();
  if (button("Take back", third, !by_recording && !task.marks().empty(), by_recording ? not_now : "nothing is marked"))
    asked.push_back({UserAction::Unmark});
  ImGui::SameLine();
  if (button("Submit", third, !by_recording, not_now)) asked.push_back({UserAction::Submit});
  ImGui::Spacing();
}

}  // namespace palpate::app
