#include "app/panels/widgets.h"

#include <imgui_internal.h>

namespace palpate::app {

std::string fitted(const std::string& text, float width) {
  const auto wide = [](const std::string& s) { return ImGui::CalcTextSize(s.data(), s.data() + s.size()).x; };
  if (wide(text) <= width) return text;
  std::string cut = text;
  const std::string dots = "...";
  while (!cut.empty() && wide(cut + dots) > width) {
    cut.pop_back();
    while (!cut.empty() && (static_cast<unsigned char>(cut.back()) & 0xC0) == 0x80) cut.pop_back();  // whole letters
    if (!cut.empty() && static_cast<unsigned char>(cut.back()) >= 0xC0) cut.pop_back();
  }
  return cut + dots;
}

const std::string& lastThatFits(const std::vector<std::string>& texts, float width) {
  for (std::size_t k = texts.size(); k-- > 1;)
    if (ImGui::CalcTextSize(texts[k].c_str()).x <= width) return texts[k];
  return texts.front();
}

bool beginPane(const char* id, const Rect& place, ImGuiWindowFlags more) {
  ImGui::SetNextWindowPos({place.x, place.y}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({place.width, place.height}, ImGuiCond_Always);
  return ImGui::Begin(id, nullptr,
                      ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                          ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                          ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav | more);
}

void keepAtEnd(const char* id) {
  ImGuiWindow* const pane = ImGui::FindWindowByName(id);
  constexpr float far_down = 1e9F;  // px
  if (pane == nullptr)
    ImGui::SetNextWindowScroll({-1, far_down});  // its first picture
  else if (pane->Scroll.y >= pane->ScrollMax.y - ImGui::GetFontSize())
    ImGui::SetScrollY(pane, far_down);
}

bool beginCard(const Theme& theme, const char* title, bool open) {
  ImGui::PushFont(theme.title);
  const bool shown = ImGui::CollapsingHeader(title, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  ImGui::PopFont();
  return shown;
}

void row(const char* name, const std::string& value, ImU32 colour, const char* hint) {
  const float left = ImGui::GetCursorPosX();
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::BeginGroup();
  ImGui::PushStyleColor(ImGuiCol_Text, colours::faint);
  ImGui::TextUnformatted(name);
  ImGui::PopStyleColor();
  const float free = width - ImGui::CalcTextSize(name).x - ImGui::GetStyle().ItemSpacing.x;
  const std::string shown = fitted(value, free);
  ImGui::SameLine();
  ImGui::SetCursorPosX(left + width - ImGui::CalcTextSize(shown.c_str()).x);
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextUnformatted(shown.c_str());
  ImGui::PopStyleColor();
  ImGui::EndGroup();
  if (ImGui::IsItemHovered()) {
    if (hint != nullptr)
      ImGui::SetTooltip("%s", hint);
    else if (shown != value)
      ImGui::SetTooltip("%s", value.c_str());
  }
}

void note(const Theme& theme, const std::string& text, ImU32 colour) {
  ImGui::PushFont(theme.small);
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

namespace {
std::map<std::string, Rect>& places() {
  static std::map<std::string, Rect> all;
  return all;
}
}  // namespace

const std::map<std::string, Rect>& buttonPlaces() { return places(); }

bool button(const char* label, float width, bool enabled, const char* reason) {
  ImGui::BeginDisabled(!enabled);
  const bool pressed = ImGui::Button(label, {width, 0});
  ImGui::EndDisabled();
  const ImVec2 corner = ImGui::GetItemRectMin(), size = ImGui::GetItemRectSize();
  places()[label] = {corner.x, corner.y, size.x, size.y};
  if (!enabled && reason != nullptr && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
    ImGui::SetTooltip("%s", reason);
  return pressed;
}

bool undoButton(float width, bool by_hand) {
  const bool pressed = button("Undo", width, by_hand, "a script or recording moves the probe: reset begins it again");
  if (by_hand && ImGui::IsItemHovered()) ImGui::SetTooltip("half a second back; again: further");
  return pressed;
}

bool slider(const char* name, float& value, float low, float high, const char* pattern, const std::string& reason) {
  row(name, format(pattern, static_cast<double>(value)), reason.empty() ? colours::text : colours::faint);
  const float thinner = ImGui::GetFontSize() / 14;  // than a line
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() - 0.6F * ImGui::GetStyle().ItemSpacing.y);
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  ImGui::PushID(name);
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, -thinner});
  ImGui::BeginDisabled(!reason.empty());
  const std::string hidden = std::string("##") + pattern;  // still what the value is rounded to
  const bool moved = ImGui::SliderFloat("##value", &value, low, high, hidden.c_str(), ImGuiSliderFlags_AlwaysClamp);
  ImGui::EndDisabled();
  ImGui::PopStyleVar();
  ImGui::PopID();
  if (!reason.empty() && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
    ImGui::SetTooltip("%s", reason.c_str());
  return moved;
}

void badge(const Theme& theme, const char* text, ImU32 colour) {
  ImGui::PushFont(theme.small);
  const ImVec2 size = ImGui::CalcTextSize(text);
  const float pad = 8 * theme.scale, height = size.y + 6 * theme.scale;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddRectFilled(at, {at.x + size.x + 2 * pad, at.y + height},
                      (colour & ~IM_COL32_A_MASK) | (48u << IM_COL32_A_SHIFT), 0.5F * height);
  draw->AddText({at.x + pad, at.y + 3 * theme.scale}, colour, text);
  ImGui::Dummy({size.x + 2 * pad, height});
  ImGui::PopFont();
}

bool menuOpen() { return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup); }

void closeMenus() {
  if (menuOpen()) ImGui::ClosePopupToLevel(0, true);
}

}  // namespace palpate::app
