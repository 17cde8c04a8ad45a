// The left column: scene, tool, material.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <vector>

#include "app/panels/panels.h"
#include "app/panels/widgets.h"

namespace palpate::app {

namespace {

constexpr double mm = 1e3, us = 1e6;  // per m, per s
constexpr double least_yield = 1e-4;  // m, worth showing
constexpr double usual_press = 0.3;   // of the deepest that can be chosen
constexpr const char* not_by_hand = "the probe is not moved by hand now";

/// "length 60 mm, rim 3 mm": what the tool's file lists, as the scene says it.
std::string toolParameters(const ToolShape& tool) {
  std::string text = format("length %.3g mm", tool.length * mm);
  std::size_t k = 0;
  for (const Parameter& parameter : toolType(tool.kind).parameters) {
    const double value = tool.parameter[k++];
    text += std::string(", ") + parameter.label + " ";
    text += std::string_view(parameter.unit) == "m" ? format("%.3g mm", value * mm)
                                                    : format("%.3g %s", value, parameter.unit);
  }
  return text;
}

std::string grouped(long long n) {
  std::string s = std::to_string(n);
  for (int at = static_cast<int>(s.size()) - 3; at > (n < 0 ? 1 : 0); at -= 3)
    s.insert(static_cast<std::size_t>(at), 1, ',');
  return s;
}

}  // namespace

namespace {

/// Cut open, see through.
void drawInside(View& view, UserActions& asked) {
  const float left = ImGui::GetCursorPosX(), half = 0.5F * ImGui::GetContentRegionAvail().x;
  bool open = view.section.on;
  if (ImGui::Checkbox("Cut open", &open)) asked.push_back({UserAction::ToggleSection});
  ImGui::SameLine(left + half);
  ImGui::Checkbox("See through", &view.ghost);
  if (view.section.on) {
    float percent = 100 * view.section.offset;
    if (slider("Cut", percent, -95, 95, "%.0f %%", "")) view.section.offset = percent / 100;
    if (button("Cut through the probe", ImGui::GetContentRegionAvail().x))
      asked.push_back({UserAction::CutThroughTool});
  }
}

}  // namespace

namespace {

/// The two ends of a locked range, in the legend's unit; dragged or typed (Ctrl+click).
void drawRange(const ColourScale& scale, View& view) {
  const ColourUnit unit = unitOf(scale.map, std::max(std::abs(scale.min), std::abs(scale.max)));
  float ends[2] = {static_cast<float>(view.colour_min * unit.per_si),
                   static_cast<float>(view.colour_max * unit.per_si)};
  const float step = std::max(1e-4F, 0.005F * (ends[1] - ends[0]));
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  const std::string pattern = unit.name[0] != '\0' ? std::string("%.3g ") + unit.name : std::string("%.3g");
  if (ImGui::DragFloat2("##range", ends, step, 0, 0, pattern.c_str()) && std::isfinite(ends[0]) &&
      std::isfinite(ends[1]) && ends[0] < ends[1]) {
    view.colour_min = static_cast<double>(ends[0]) / unit.per_si;
    view.colour_max = static_cast<double>(ends[1]) / unit.per_si;
  }
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("drag, or Ctrl+click to type; what lies below or above is striped on the skin");
}

}  // namespace

void drawViewCard(const Theme& theme, const PanelData& data, const PanelState& state, View& view, UserActions& asked) {
  if (!beginCard(theme, "View")) return;
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  if (ImGui::BeginCombo("##colour", quantityName(view.colour_map))) {
    for (int k = 0; k < (data.task != nullptr ? 5 : 4); ++k) {
      const auto map = static_cast<ColourMap>(k);
      if (data.searching() && (map == ColourMap::VonMises || map == ColourMap::J)) continue;
      if (ImGui::Selectable(format("%d  %s", k + 1, quantityName(map)).c_str(), map == view.colour_map)) {
        view.colour_map = map;
        view.colour_auto = true;
      }
    }
    ImGui::EndCombo();
  }
  const float half = 0.5F * ImGui::GetContentRegionAvail().x;
  const float left = ImGui::GetCursorPosX();
  if (view.colour_map != ColourMap::Tissue) {
    bool locked = !view.colour_auto;
    if (ImGui::Checkbox("Lock the colours' range", &locked)) {
      view.colour_auto = !locked;
      view.colour_min = data.colour_scale.min;
      view.colour_max = data.colour_scale.max;
    }
    if (locked) drawRange(data.colour_scale, view);
  }
  ImGui::Checkbox("Tool force", &view.show_forces);
  ImGui::SameLine(left + half);
  ImGui::Checkbox("Contact", &view.show_contact);
  ImGui::Checkbox("Fixed skin", &view.show_fixed);
  ImGui::SameLine(left + half);
  ImGui::Checkbox("Tool", &view.show_tool);
  if (data.searching()) {
    note(theme, "What shows the inside (cut, seeing through, stress, nodes) waits until the answers are in.");
  } else {
    if (state.engineer) {
      ImGui::Checkbox("Nodes", &view.show_nodes);
      ImGui::SameLine(left + half);
      ImGui::Checkbox("Points", &view.show_points);
    }
    drawInside(view, asked);
  }
  ImGui::Spacing();
}

void drawNumbersCard(const Theme& theme, const PanelData& data) {
  if (!beginCard(theme, "Model", false)) return;
  const Body& model = data.model;
  row("Nodes", grouped(model.nodeCount()));
  row("Integration points", grouped(model.pointCount()));
  row("Nodes per point", format("%.1f", model.point_shape.meanSupport()), colours::text,
      "mean size of an integration point's support");
  row("Time step", format("%.1f us x %d", model.dt * us, model.substeps_per_tick), colours::text,
      "dt and how many of them make one tick");
  row("Step / stable limit", format("%.0f %%", 100 * model.dt / model.dt_critical), colours::text,
      "dt over the critical step of the operator at rest");
  if (model.scene.dynamics.mass_scaling > 0)
    row("Mass added", format("%.3g %%", 100 * model.addedMass()), colours::text,
        "to spare steps: forces at rest are the same, motion is slower");
  const double volume_error = 100 * (model.cell_volume / model.surface_volume - 1);
  row("Volume error", format("%+.2f %%", volume_error), std::abs(volume_error) < 2 ? colours::text : colours::warning,
      "background cells against the organ's own surface");
  ImGui::Spacing();
}

namespace {

/// Shape and radius, and a button that loads the scene anew with them.
void drawProbeChoice(const PanelData& data, PanelState& state, UserActions& asked) {
  const ToolShape& tool = data.model.scene.tools[0].shape;
  if (!state.tool_edited || data.searching()) state.tool = {tool.kind, tool.radius}, state.tool_edited = false;
  ImGui::BeginDisabled(data.searching());
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  if (ImGui::BeginCombo("##shape", toolType(state.tool.kind).title)) {
    int k = 0;
    for (const ToolType* type : toolTypes()) {
      const auto kind = static_cast<ToolKind>(k++);
      if (ImGui::Selectable(type->title, kind == state.tool.kind)) {
        state.tool.kind = kind;
        state.tool_edited = true;
      }
    }
    ImGui::EndCombo();
  }
  ImGui::EndDisabled();
  auto radius = static_cast<float>(state.tool.radius * mm);
  const char* const closed = data.searching() ? "a search is made with the scene's probe" : "";
  if (slider("Radius", radius, 3, 30, "%.1f mm", closed)) {
    state.tool.radius = static_cast<double>(radius) / mm;
    state.tool_edited = true;
  }
  if (!state.tool_edited) return;
  const float half = 0.5F * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  if (button("Use this probe", half)) asked.push_back({UserAction::UseProbe});
  ImGui::SameLine();
  if (button("Keep the old", half)) state.tool_edited = false;
}

/// What the wheel and keys do, by clicks.
void drawPressing(const PanelData& data, PanelState& state, bool by_hand, UserActions& asked) {
  const double most = 2 * mm * data.model.scene.tools[0].shape.radius;
  if (!(state.press_mm > 0)) state.press_mm = usual_press * most;
  state.press_mm = std::min(state.press_mm, most);
  const float half = 0.5F * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  if (button("Press", half, by_hand, not_by_hand)) asked.push_back({UserAction::Press});
  if (by_hand && ImGui::IsItemHovered()) ImGui::SetTooltip("End: so deep into the skin below the probe");
  ImGui::SameLine();
  if (button("Lift", half, by_hand, not_by_hand)) asked.push_back({UserAction::Lift});
  if (by_hand && ImGui::IsItemHovered()) ImGui::SetTooltip("Home: off the skin");
  auto depth = static_cast<float>(state.press_mm);
  if (slider("Press by", depth, 0.5F, static_cast<float>(most), "%.1f mm", by_hand ? "" : not_by_hand)) {
    state.press_mm = static_cast<double>(depth);
    if (data.hand_presses) asked.push_back({UserAction::Press});
  }
  if (!(data.widest_jaws_m > 0)) return;
  auto opening = static_cast<float>(mm * data.snapshot.tools.tool[0].opening);
  if (slider("Jaws open", opening, 0, static_cast<float>(mm * data.widest_jaws_m), "%.1f mm",
             by_hand ? "" : not_by_hand))
    asked.push_back({UserAction::OpenJaws, static_cast<double>(opening) / mm});
  if (button("Grasp and lift", ImGui::GetContentRegionAvail().x, by_hand, not_by_hand))
    asked.push_back({UserAction::Grasp});
  if (by_hand && ImGui::IsItemHovered())
    ImGui::SetTooltip("closes the jaws until they hold, then lifts what they hold");
}

}  // namespace

void drawToolCard(const Theme& theme, const PanelData& data, PanelState& state, UserActions& asked) {
  if (!beginCard(theme, "Probe")) return;
  const bool by_hand = data.driver == ToolDriver::User;
  const float half = 0.5F * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  const float left = ImGui::GetCursorPosX();
  if (ImGui::RadioButton("On the skin", state.glide)) asked.push_back({UserAction::SetGlide, 1});
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("click the skin: the probe comes there and glides with the pointer");
  ImGui::SameLine(left + half);
  if (ImGui::RadioButton("Free", !state.glide)) asked.push_back({UserAction::SetGlide, 0});
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Shift+drag moves the probe in the view's plane");
  drawPressing(data, state, by_hand, asked);
  drawProbeChoice(data, state, asked);
  const ForceSample& force = data.snapshot.force;
  row(force.depth_m < 0 ? "Gap to the skin" : "Depth", format("%.2f mm", std::abs(force.depth_m) * mm), colours::text,
      format("how far the skin under the tip is pressed from where it lay at rest, along the contact's normal; "
             "advance along the start axis: %.2f mm; %s",
             force.advance_m * mm, toolParameters(data.model.scene.tools[0].shape).c_str())
          .c_str());
  if (data.snapshot.yield_m > least_yield)
    row("Behind the hand", format("%.1f mm", data.snapshot.yield_m * mm), colours::warning,
        "the tool stands before what is rigid, or yields: the tissue can take no more (tool.max_force and others); the "
        "ghost is the hand");
  if (data.snapshot.status.restored_count > 0)
    row("Set back", format("%lld times", static_cast<long long>(data.snapshot.status.restored_count)), colours::warning,
        "the tissue could take no more, and went back to where it was shortly before");
  const Vec3 tip = data.snapshot.toolPose().position * mm;
  if (state.engineer)
    row("Tip", format("%.1f  %.1f  %.1f mm", tip.x(), tip.y(), tip.z()), colours::text,
        format("%d skin vertices touched", data.snapshot.report.contact_count).c_str());
  auto friction = static_cast<float>(data.friction);
  if (slider("Friction", friction, 0, 1, "%.2f", data.input_note)) asked.push_back({UserAction::SetFriction, friction});
  auto speed = static_cast<float>(state.tool_speed_mm_s);
  if (slider("Key speed", speed, 1, 100, "%.0f mm/s", "")) state.tool_speed_mm_s = speed;

  if (button("Upright", half, by_hand, not_by_hand)) asked.push_back({UserAction::Upright});
  ImGui::SameLine();
  if (button("To start pose", half, by_hand, not_by_hand)) asked.push_back({UserAction::ToStart});
  if (!data.script.empty() && button("Play script again", 2 * half + ImGui::GetStyle().ItemSpacing.x))
    asked.push_back({UserAction::RestartScript});
  switch (data.driver) {
    case ToolDriver::User:
      if (!state.engineer)
        note(theme, data.hand_on_skin ? "Drag it over the skin; a right drag on the probe tilts it"
                    : state.glide     ? "Click the skin to bring the probe there, then Press"
                                      : "Drag the probe; the wheel meanwhile pushes it, a right drag tilts it");
      break;
    case ToolDriver::Script:
      note(theme, "Moved by the script " + data.script);
      break;
    case ToolDriver::Replay:
      note(theme, "Moved by the recording " + data.script);
      break;
  }
  ImGui::Spacing();
}

}  // namespace palpate::app
