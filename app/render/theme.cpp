#include "app/render/theme.h"

#include <cmath>
#include <filesystem>

namespace palpate::app {

namespace {

constexpr const char* font_file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";        // Debian fonts-dejavu-core
constexpr float body_px = 14, small_px = 11.5F, title_px = 15, large_px = 25, big_px = 34;  // scale 1

/// Latin, Greek, punctuation, arrows and mathematical signs.
constexpr ImWchar letters[] = {0x0020, 0x00FF, 0x0370, 0x03FF, 0x2010, 0x2027, 0x2070, 0x209F,
                               0x2190, 0x21FF, 0x2200, 0x22FF, 0x25A0, 0x25FF, 0};

ImFont* addFont(const char* file, float px) {
  ImGuiIO& io = ImGui::GetIO();
  if (file != nullptr) {
    ImFontConfig config;
    config.OversampleH = 2;
    config.OversampleV = 1;
    return io.Fonts->AddFontFromFileTTF(file, std::round(px), &config, letters);
  }
  ImFontConfig config;
  config.SizePixels = std::round(px);
  return io.Fonts->AddFontDefault(&config);
}

ImVec4 rgb(int r, int g, int b, float a = 1) { return {r / 255.0F, g / 255.0F, b / 255.0F, a}; }

}  // namespace

Theme makeTheme(float scale) {
  Theme theme;
  theme.scale = scale;
  std::error_code ignored;
  theme.has_greek = std::filesystem::is_regular_file(font_file, ignored);
  const char* file = theme.has_greek ? font_file : nullptr;
  theme.body = addFont(file, body_px * scale);
  theme.small = addFont(file, small_px * scale);
  theme.title = addFont(file, title_px * scale);
  theme.large = addFont(file, large_px * scale);
  theme.big = addFont(file, big_px * scale);

  ImGui::GetIO().IniFilename = nullptr;  // no file left in the user's folder
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  ImGui::StyleColorsDark(&style);
  style.WindowRounding = 8;
  style.ChildRounding = 6;
  style.FrameRounding = 5;
  style.PopupRounding = 6;
  style.GrabRounding = 5;
  style.ScrollbarRounding = 6;
  style.ScrollbarSize = 10;
  style.WindowBorderSize = 1;
  style.FrameBorderSize = 0;
  style.WindowPadding = {10, 8};
  style.FramePadding = {8, 4};
  style.ItemSpacing = {8, 5};
  style.ItemInnerSpacing = {6, 4};
  style.CellPadding = {4, 2};
  style.WindowMenuButtonPosition = ImGuiDir_None;
  style.ScaleAllSizes(scale);

  ImVec4* c = style.Colors;
  c[ImGuiCol_Text] = ImGui::ColorConvertU32ToFloat4(colours::text);
  c[ImGuiCol_TextDisabled] = ImGui::ColorConvertU32ToFloat4(colours::faint);
  c[ImGuiCol_WindowBg] = rgb(22, 26, 32, 0.96F);
  c[ImGuiCol_PopupBg] = rgb(26, 31, 38, 0.98F);
  c[ImGuiCol_ChildBg] = rgb(0, 0, 0, 0);
  c[ImGuiCol_Border] = rgb(255, 255, 255, 0.08F);
  c[ImGuiCol_FrameBg] = rgb(38, 44, 53);
  c[ImGuiCol_FrameBgHovered] = rgb(48, 56, 67);
  c[ImGuiCol_FrameBgActive] = rgb(56, 66, 79);
  c[ImGuiCol_Button] = rgb(44, 52, 63);
  c[ImGuiCol_ButtonHovered] = rgb(56, 70, 84);
  c[ImGuiCol_ButtonActive] = rgb(62, 96, 114);
  c[ImGuiCol_Header] = rgb(33, 39, 48);
  c[ImGuiCol_HeaderHovered] = rgb(42, 50, 61);
  c[ImGuiCol_HeaderActive] = rgb(46, 56, 68);
  c[ImGuiCol_CheckMark] = ImGui::ColorConvertU32ToFloat4(colours::accent);
  c[ImGuiCol_SliderGrab] = ImGui::ColorConvertU32ToFloat4(colours::grab);
  c[ImGuiCol_SliderGrabActive] = ImGui::ColorConvertU32ToFloat4(colours::accent);
  c[ImGuiCol_PlotHistogram] = ImGui::ColorConvertU32ToFloat4(colours::progress);  // a value is written over it
  c[ImGuiCol_Separator] = rgb(255, 255, 255, 0.08F);
  c[ImGuiCol_ScrollbarBg] = rgb(0, 0, 0, 0);
  c[ImGuiCol_ScrollbarGrab] = rgb(62, 70, 82);
  c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = rgb(28, 33, 41);
  return theme;
}

}  // namespace palpate::app
