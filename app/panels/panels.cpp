#include "app/panels/panels.h"

#include <imgui.h>

#include <algorithm>
#include <string>
#include <vector>

#include "app/panels/widgets.h"

namespace palpate::app {

namespace {

struct RunState {
  const char* text;
  ImU32 colour;
};

RunState runState(const LoopStatus& status, bool past) {
  if (past) return {"THE PAST", colours::warning};
  if (status.frozen) return {"FROZEN", colours::bad};
  if (status.paused) return {"PAUSED", colours::warning};
  return {"RUNNING", colours::good};
}

/// Of the view, what legend and timeline leave.
Rect aboveFoot(const Theme& theme, const PanelData& data, const PanelState& state, Rect view) {
  if (data.colour_scale.map != ColourMap::Tissue) view.height -= legend_room * theme.scale;
  if (state.timeline_shown && data.timeline) view.height -= timeline_room * theme.scale;
  return view;
}

}  // namespace

UserActions drawPanels(const Theme& theme, const PanelData& data, const Layout& layout, PanelState& state, View& view) {
  UserActions asked;
  ImGui::PushFont(theme.body);
  const auto taskCard = [&] {
    if (data.task != nullptr) drawTaskCard(theme, data, state, view, asked);
  };
  const auto tissueCards = [&] {
    drawToolCard(theme, data, state, asked);
    drawViewCard(theme, data, state, view, asked);
    drawMaterialCard(theme, data, state, asked);
    if (state.engineer) drawNumbersCard(theme, data);
  };
  if (layout.panels) {
    drawBar(theme, data, layout.bar, state, asked);
    if (layout.left.width > 0) {
      if (beginPane("##left", layout.left)) {
        taskCard();
        tissueCards();
      }
      ImGui::End();
    }
    if (layout.right.width > 0) {
      if (beginPane("##right", layout.right)) {
        if (layout.left.width <= 0) taskCard();  // its buttons are always at hand, and short enough to leave the force
        drawForceCard(theme, data, layout.right.height, state, asked);
        if (layout.left.width <= 0) tissueCards();  // one column for all, to be scrolled
        if (!data.timeless && state.engineer) drawTimingCard(theme, data, layout.left.width > 0);
      }
      ImGui::End();
    }
    if (layout.log.width > 0 && !data.timeless) drawLog(theme, data, state.engineer, layout.log);
  } else if (state.demo) {
    drawDemoForce(theme, data);
  }
  const bool demo = !layout.panels && state.demo;
  const Rect free = demo ? besideDemoForce(layout.view, demoForcePlace(theme, data), theme.scale) : layout.view;
  drawLegend(theme, data, free);
  if (state.timeline_shown && data.timeline) drawTimeline(theme, data, free, state, asked);
  drawPullForce(theme, data);
  // Its buttons are for somebody who looks on; a picture of the organ alone has none.
  const bool organ_alone = data.timeless && !state.panels_shown;
  const bool told = data.notice && !data.attracts;  // which nobody's hand has caused
  if ((told || data.snapshot.status.frozen) && !organ_alone)
    drawNotice(theme, data, demo ? aboveFoot(theme, data, state, free) : layout.view, demo, asked);
  if (demo && data.attracts) drawInvitation(theme, aboveFoot(theme, data, state, free));
  if (data.out_of_view && drawCall(theme, "The organ is out of view: F", layout.view))
    asked.push_back({UserAction::FrameView});
  if (state.help_shown) drawHelp(theme, state);
  if (state.open_shown) drawOpenDialog(theme, data, state, asked);
  if (!state.problem.empty()) drawProblem(theme, state);
  if (!state.at_stake.empty()) drawQuitDialog(theme, state, asked);
  ImGui::PopFont();
  return asked;
}

void drawBar(const Theme& theme, const PanelData& data, const Rect& place, PanelState& state, UserActions& asked) {
  const LoopStatus& status = data.snapshot.status;
  if (beginPane("##bar", place, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse)) {
    const float s = theme.scale;
    const float text_y = 0.5F * (place.height - ImGui::GetFontSize());
    const float button_y = 0.5F * (place.height - ImGui::GetFrameHeight());
    const auto at = [&](float x, float y) { ImGui::SetCursorPos({x, y}); };

    // In a narrow window the buttons stay, and what can be seen elsewhere goes.
    const bool wide = place.width >= 1300 * s, roomy = place.width >= 900 * s, narrow = place.width < 700 * s;
    const bool past = data.timeline && data.timeline->past;  // the run waits meanwhile
    const bool waits = status.paused || past;
    if (!narrow) {
      at(14 * s, text_y - s);
      ImGui::PushFont(theme.title);
      ImGui::TextUnformatted("Palpate");
      ImGui::PopFont();
    }
    if (roomy) {
      ImGui::SameLine(0, 12 * s);
      ImGui::SetCursorPosY(text_y);
      ImGui::TextDisabled("%s", fitted(data.model.scene.name, (wide ? 250 : 110) * s).c_str());
    }
    if (!narrow) ImGui::SameLine(0, 16 * s);
    if (narrow) ImGui::SetCursorPosX(5 * s);
    ImGui::SetCursorPosY(0.5F * (place.height - theme.small->FontSize - 6 * s));
    const RunState run = data.timeless ? RunState{"SNAPSHOT", colours::accent} : runState(status, past);
    badge(theme, run.text, run.colour);

    float x = (wide ? 440 : roomy ? 300 : narrow ? 88 : 190) * s;
    const float width = (narrow ? 60 : 66) * s, next = width + (narrow ? 3 : 6) * s;
    at(x, button_y);
    if (button("File", width)) ImGui::OpenPopup("##file");
    ImGui::SetNextWindowPos({ImGui::GetItemRectMin().x, ImGui::GetItemRectMax().y + 4 * s}, ImGuiCond_Appearing);
    drawFileMenu(theme, data, state, asked);
    at(x += next, button_y);
    if (button(waits ? "Run" : "Pause", width, !status.frozen, "frozen: reset first"))
      asked.push_back({UserAction::TogglePause});
    at(x += next, button_y);
    if (button("Step", width, waits && !status.frozen, "pause first, then single ticks can be made"))
      asked.push_back({UserAction::SingleStep});
    at(x += next, button_y);
    if (button("Reset", width)) asked.push_back({UserAction::Reset});
    at(x += next, button_y);
    const bool by_hand = data.driver == ToolDriver::User;
    if (undoButton(width, by_hand)) asked.push_back({UserAction::Undo});
    at(x += next, button_y);
    if (button("Frame", width)) asked.push_back({UserAction::FrameView});
    x += width + 16 * s;

    // Figures stand at the right end, so that the buttons never move.
    std::vector<std::string> figures{"", format("t %.2f s", data.snapshot.force.time_s)};  // each with one more
    const bool slow = !waits && !data.timeless && status.recent_realtime_factor < 0.99;
    if (!data.timeless && (state.engineer || slow))
      figures.push_back(figures.back() + format("   real time x%.3f", status.recent_realtime_factor));
    if (data.frames_per_second > 0 && state.engineer)
      figures.push_back(figures.back() + format("   %.0f fps", data.frames_per_second));
    const float help_width = 64 * s, box_width = 92 * s;
    const bool has_box = x + box_width + help_width <= place.width;  // else in the File menu
    const float engineer_width = has_box ? box_width : 0;
    const float right = place.width - help_width - engineer_width - 10 * s;
    const std::string& shown = lastThatFits(figures, right - 12 * s - x);
    at(right - 12 * s - ImGui::CalcTextSize(shown.c_str()).x, text_y);
    ImGui::PushStyleColor(ImGuiCol_Text, slow ? colours::warning : colours::text);
    ImGui::TextUnformatted(shown.c_str());
    ImGui::PopStyleColor();
    if (has_box) {
      at(right, button_y);
      ImGui::Checkbox("Engineer", &state.engineer);
      if (ImGui::IsItemHovered())
        ImGui::SetTooltip("E: also the numbers that only those who build scenes and programs need");
    }
    at(right + engineer_width, button_y);
    if (button("F1 help", help_width)) asked.push_back({UserAction::ToggleHelp});
  }
  ImGui::End();
}

void drawLog(const Theme& theme, const PanelData& data, bool engineer, const Rect& place) {
  // As high as its lines are in today's width, before they are drawn: else the first picture of another size would show
  // where they ended in the last one.
  const float text_left = 62 * theme.scale;
  const auto listed = [=](const LogLine& line) { return line.level != LogLevel::Detail || engineer; };
  if (std::none_of(data.log.begin(), data.log.end(), listed)) return;
  ImGui::PushFont(theme.small);
  const ImGuiStyle& style = ImGui::GetStyle();
  const float width = place.width - 2 * style.WindowPadding.x - style.ScrollbarSize - text_left;
  float height = 0;
  for (const LogLine& line : data.log)
    if (listed(line))
      height += ImGui::CalcTextSize(line.text.c_str(), nullptr, false, std::max(1.0F, width)).y + style.ItemSpacing.y;
  ImGui::PopFont();
  ImGui::SetNextWindowContentSize({0, height});
  keepAtEnd("##log");  // the newest line, unless the user scrolled up to read
  if (beginPane("##log", place)) {
    ImGui::PushFont(theme.small);
    for (const LogLine& line : data.log) {
      if (!listed(line)) continue;
      const ImU32 colour = line.level == LogLevel::Error     ? colours::bad
                           : line.level == LogLevel::Warning ? colours::warning
                                                             : colours::text;
      ImGui::PushStyleColor(ImGuiCol_Text, colours::faint);
      const float left = ImGui::GetCursorPosX();
      const std::string time = line.run_s ? format("%.2f s", *line.run_s) : std::string();
      ImGui::SetCursorPosX(left + 52 * theme.scale - ImGui::CalcTextSize(time.c_str()).x);
      ImGui::TextUnformatted(time.c_str());
      ImGui::PopStyleColor();
      ImGui::SameLine();
      ImGui::SetCursorPosX(left + text_left);
      ImGui::PushStyleColor(ImGuiCol_Text, colour);
      ImGui::PushTextWrapPos(0);
      ImGui::TextUnformatted(line.text.c_str());
      ImGui::PopTextWrapPos();
      ImGui::PopStyleColor();
    }
    ImGui::PopFont();
  }
  ImGui::End();
}

}  // namespace palpate::app
