#pragma once

#include <imgui.h>

namespace palpate::app {

/// The look of the panels: colours that carry meaning, five sizes of one font, and
/// ImGui's style set to match. One instance per ImGui context; lengths in panels are
/// multiples of `scale`.
struct Theme {
  float scale = 1;  // 1 on a plain screen, 2 on a high-DPI one
  ImFont* body = nullptr;
  ImFont* small = nullptr;
  ImFont* title = nullptr;
  ImFont* large = nullptr;  // to be read from some steps away
  ImFont* big = nullptr;    // the force in newtons
  bool has_greek = false;   // the font has the letters of the field (nu, mu, ...)
};

namespace colours {
inline constexpr ImU32 text = IM_COL32(226, 230, 236, 255);
inline constexpr ImU32 faint = IM_COL32(139, 148, 161, 255);
inline constexpr ImU32 grid = IM_COL32(255, 255, 255, 20);
inline constexpr ImU32 frame = IM_COL32(255, 255, 255, 34);
inline constexpr ImU32 plot_ground = IM_COL32(13, 16, 21, 255);
inline constexpr ImU32 raw = IM_COL32(112, 128, 150, 255);    // the raw force
inline constexpr ImU32 stale = IM_COL32(134, 141, 152, 255);  // a force that is not the present one
inline constexpr ImU32 accent = IM_COL32(94, 196, 222, 255);  // the filtered force
inline constexpr ImU32 grab = IM_COL32(78, 150, 172, 255);    // of sliders
inline constexpr ImU32 progress = IM_COL32(58, 102, 119, 255);
inline constexpr ImU32 good = IM_COL32(112, 201, 136, 255);
inline constexpr ImU32 warning = IM_COL32(236, 184, 88, 255);
inline constexpr ImU32 frozen_banner = IM_COL32(70, 24, 24, 245);
inline constexpr ImU32 notice_banner = IM_COL32(58, 44, 20, 240);
inline constexpr ImU32 bad = IM_COL32(238, 106, 98, 255);
}  // namespace colours

/// Loads the fonts and sets ImGui's style in the current context. `scale` is the
/// screen's content scale (glfwGetWindowContentScale). Where DejaVu Sans is not
/// installed, ImGui's own bitmap font is used at the same sizes.
Theme makeTheme(float scale);

}  // namespace palpate::app
