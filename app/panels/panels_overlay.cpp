// What lies over the view: the legend of the colours and the help.
#include <imgui.h>

#include <algorithm>
#include <array>

#include "app/figures/round_ticks.h"
#include "app/panels/panels.h"
#include "app/panels/plot.h"
#include "app/panels/widgets.h"

namespace palpate::app {

namespace {

ImU32 packed(const Vec3f& c) { return ImGui::ColorConvertFloat4ToU32({c.x(), c.y(), c.z(), 1}); }

struct HelpLine {
  const char* keys;
  const char* what;
};

constexpr std::array view_help{
    HelpLine{"Left or middle drag", "turn the view (left: beside the organ)"},
    HelpLine{"Right drag", "move the view"},
    HelpLine{"Wheel, F", "nearer, further; the whole organ"},
    HelpLine{"X, G", "cut the organ open, see through its skin"},
    HelpLine{"1 2 3 4, N, P", "tissue, displacement, stress, volume; nodes, points"},
    HelpLine{"H, E, F10, F11", "hide panels, engineer, demo, full screen"},
    HelpLine{"F12", "save the picture"},
};
constexpr std::array tool_help{
    HelpLine{"Click the skin", "bring the probe there; drag to glide"},
    HelpLine{"Shift + left drag", "move the probe in the view's plane"},
    HelpLine{"Shift + wheel", "press in; while dragging the wheel alone"},
    HelpLine{"End, Home", "press as deep as is set, lift off"},
    HelpLine{"PageDown, PageUp", "press in, draw back while held"},
    HelpLine{"Arrow keys", "move the probe sideways"},
    HelpLine{"I J K L, right drag on it", "tilt the probe"},
    HelpLine{"B, - +, Enter", "another probe, smaller, larger; use it"},
    HelpLine{"C, V; M, U", "close, open jaws; mark a lump, how hard"},
    HelpLine{"Ctrl + left drag", "pull the tissue under the pointer"},
};
constexpr std::array run_help{
    HelpLine{"Space, .", "pause and run, one tick"},
    HelpLine{"Backspace", "reset"},
    HelpLine{"Ctrl + Z, T", "half a second back; look back a minute"},
    HelpLine{"Ctrl + O, Ctrl + S", "open a scene, save the forces"},
    HelpLine{"F1", "this help"},
    HelpLine{"Esc", "close what is open; quit"},
};

void drawHelpSection(const Theme& theme, const char* title, std::span<const HelpLine> lines) {
  ImGui::PushFont(theme.small);
  ImGui::PushStyleColor(ImGuiCol_Text, colours::accent);
  ImGui::TextUnformatted(title);
  ImGui::PopStyleColor();
  ImGui::PopFont();
  for (const HelpLine& line : lines) {
    const float left = ImGui::GetCursorPosX();
    ImGui::TextUnformatted(line.keys);
    ImGui::SameLine(left + 150 * theme.scale);
    ImGui::TextDisabled("%s", line.what);
  }
  ImGui::Spacing();
  ImGui::Spacing();
}

}  // namespace

void drawLegend(const Theme& theme, const PanelData& data, const Rect& view) {
  const ColourScale& scale = data.colour_scale;
  if (scale.map == ColourMap::Tissue || !(scale.max > scale.min)) return;
  const float s = theme.scale;
  const float width = std::min(view.width - 40 * s, 280 * s), height = 58 * s;
  const ImVec2 corner{view.x + 0.5F * (view.width - width), view.bottom() - height - 10 * s};
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  draw->AddRectFilled(corner, {corner.x + width, corner.y + height}, IM_COL32(22, 26, 32, 200), 8 * s);

  ImGui::PushFont(theme.small);
  const ColourUnit unit = unitOf(scale.map, std::max(std::abs(scale.min), std::abs(scale.max)));
  std::string title = quantityName(scale.map);
  const std::vector<Material>& present = data.snapshot.materials;
  if (scale.map == ColourMap::VonMises &&
      std::any_of(present.begin(), present.end(), [](const Material& m) { return m.relaxation_count > 0; }))
    title += " before it relaxes";
  if (unit.name[0] != '\0') title += std::string(", ") + unit.name;
  const float title_width = ImGui::CalcTextSize(title.c_str()).x;
  draw->AddText({corner.x + 0.5F * (width - title_width), corner.y + 6 * s}, colours::text, title.c_str());

  const ImVec2 a{corner.x + 14 * s, corner.y + 24 * s}, b{corner.x + width - 14 * s, corner.y + 36 * s};
  constexpr int bands = 64;
  for (int k = 0; k < bands; ++k) {
    const float x0 = a.x + (b.x - a.x) * static_cast<float>(k) / bands;
    const float x1 = a.x + (b.x - a.x) * static_cast<float>(k + 1) / bands;
    draw->AddRectFilledMultiColor({x0, a.y}, {x1, b.y}, packed(colourOf(scale.map, static_cast<double>(k) / bands)),
                                  packed(colourOf(scale.map, static_cast<double>(k + 1) / bands)),
                                  packed(colourOf(scale.map, static_cast<double>(k + 1) / bands)),
                                  packed(colourOf(scale.map, static_cast<double>(k) / bands)));
  }
  // Arrowheads where values lie beyond an end: what is striped on the skin.
  const float middle = 0.5F * (a.y + b.y);
  if (scale.below)
    draw->AddTriangleFilled({a.x - 2 * s, a.y}, {a.x - 2 * s, b.y}, {a.x - 10 * s, middle}, packed(belowColour()));
  if (scale.above)
    draw->AddTriangleFilled({b.x + 2 * s, a.y}, {b.x + 2 * s, b.y}, {b.x + 10 * s, middle}, packed(aboveColour()));
  if (scale.below) draw->AddTriangle({a.x - 2 * s, a.y}, {a.x - 2 * s, b.y}, {a.x - 10 * s, middle}, colours::faint, s);
  const double low = scale.min * unit.per_si, high = scale.max * unit.per_si;
  const auto ticks = roundTicks(low, high, 5);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : high - low;
  for (double value : ticks) {
    const float x = a.x + (b.x - a.x) * static_cast<float>((value - low) / (high - low));
    const std::string label = tickLabel(value, step);
    const float label_width = ImGui::CalcTextSize(label.c_str()).x;
    draw->AddLine({x, b.y}, {x, b.y + 3 * s}, colours::text);
    draw->AddText(
        {std::clamp(x - 0.5F * label_width, corner.x + 4 * s, corner.x + width - label_width - 4 * s), b.y + 4 * s},
        colours::text, label.c_str());
  }
  ImGui::PopFont();
}

void drawHelp(const Theme& theme, PanelState& state) {
  const float s = theme.scale;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * display.x, 0.5F * display.y}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {display.x - 20 * s, display.y - 20 * s});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {22 * s, 16 * s});
  ImGui::SetNextWindowFocus();
  ImGui::SetNextWindowBgAlpha(1);
  if (ImGui::Begin("##help", nullptr,
                   ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                       ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings)) {
    ImGui::PushFont(theme.title);
    ImGui::TextUnformatted("Keys and mouse");
    ImGui::PopFont();
    ImGui::Spacing();
    drawHelpSection(theme, "THE PROBE AND THE TISSUE", tool_help);
    drawHelpSection(theme, "THE VIEW", view_help);
    drawHelpSection(theme, "THE RUN", run_help);
    if (button("Close", 90 * s)) state.help_shown = false;
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

}  // namespace palpate::app
