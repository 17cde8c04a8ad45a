#pragma once

#include <imgui.h>

#include <span>
#include <string>
#include <vector>

namespace palpate::app {

/// The colours of what stands on paper beside the data.
namespace paper {
inline constexpr ImU32 white = IM_COL32(255, 255, 255, 255);
inline constexpr ImU32 ink = IM_COL32(30, 34, 40, 255);
inline constexpr ImU32 faint = IM_COL32(88, 95, 105, 255);
inline constexpr ImU32 grid = IM_COL32(224, 227, 232, 255);
inline constexpr ImU32 fine_grid = IM_COL32(241, 243, 245, 255);
inline constexpr ImU32 frame = IM_COL32(128, 134, 142, 255);
}  // namespace paper

/// A rectangle, px.
struct Box {
  float left = 0, top = 0, right = 0, bottom = 0;

  float width() const { return right - left; }
  float height() const { return bottom - top; }
  bool meets(const Box& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
  bool holds(const ImVec2& p) const { return p.x >= left && p.x <= right && p.y >= top && p.y <= bottom; }
  bool holds(const Box& other) const {
    return other.left >= left && other.right <= right && other.top >= top && other.bottom <= bottom;
  }
};

/// `colour` with another opacity, 0..1.
ImU32 faded(ImU32 colour, double opacity);

/// Size of a text in a font, px.
ImVec2 textSize(ImFont* font, const std::string& text);

/// Writes with the anchor (0 left or upper end, 0.5 middle, 1 right or lower end) at `place`,
/// on whole pixels. @return the text's box
Box writeText(ImDrawList& draw, ImFont* font, ImVec2 place, ImVec2 anchor, ImU32 colour, const std::string& text);

/// Writes upwards, with the text's middle at `middle`.
void writeUpwards(ImDrawList& draw, ImFont* font, ImVec2 middle, ImU32 colour, const std::string& text);

/// A line through points, px; `dash` > 0 makes it dashed with dashes of that length.
void strokeLine(ImDrawList& draw, std::span<const ImVec2> points, ImU32 colour, float thickness, float dash = 0);

/// One of four shapes (circle, square, diamond, triangle) in a thin white rim, so that points
/// on a line, or on each other, stay apart.
void drawMarker(ImDrawList& draw, ImVec2 centre, int shape, float radius, ImU32 colour);

}  // namespace palpate::app
