#include "app/figures/paper.h"

#include <cmath>

namespace palpate::app {
namespace {

/// The corners of a marker's shape; all shapes cover about the same area.
std::vector<ImVec2> markerCorners(ImVec2 c, int shape, float r) {
  switch (shape % 4) {
    case 1: {
      const float h = 0.88F * r;
      return {{c.x - h, c.y - h}, {c.x + h, c.y - h}, {c.x + h, c.y + h}, {c.x - h, c.y + h}};
    }
    case 2: {
      const float h = 1.25F * r;
      return {{c.x, c.y - h}, {c.x + h, c.y}, {c.x, c.y + h}, {c.x - h, c.y}};
    }
    default: {
      const float h = 1.3F * r;
      return {{c.x, c.y - h}, {c.x + 0.87F * h, c.y + 0.5F * h}, {c.x - 0.87F * h, c.y + 0.5F * h}};
    }
  }
}

/// ImGui tears a line open where it turns sharply: there it is cut and the corner is rounded.
void strokeRun(ImDrawList& draw, std::span<const ImVec2> points, ImU32 colour, float thickness) {
  constexpr float sharp_cosine = 0.7F;
  std::size_t first = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    bool cut = i + 1 == points.size();
    if (!cut) {
      const ImVec2 a{points[i].x - points[i - 1].x, points[i].y - points[i - 1].y};
      const ImVec2 b{points[i + 1].x - points[i].x, points[i + 1].y - points[i].y};
      cut = a.x * b.x + a.y * b.y < sharp_cosine * std::hypot(a.x, a.y) * std::hypot(b.x, b.y);
      if (cut) draw.AddCircleFilled(points[i], 0.5F * thickness, colour);
    }
    if (!cut) continue;
    draw.AddPolyline(&points[first], static_cast<int>(i - first + 1), colour, 0, thickness);
    first = i;
  }
}

}  // namespace

ImU32 faded(ImU32 colour, double opacity) {
  return (colour & ~IM_COL32_A_MASK) | (static_cast<ImU32>(std::lround(255 * opacity)) << IM_COL32_A_SHIFT);
}

ImVec2 textSize(ImFont* font, const std::string& text) {
  return font->CalcTextSizeA(font->FontSize, 1e9F, 0, text.c_str(), text.c_str() + text.size());
}

Box writeText(ImDrawList& draw, ImFont* font, ImVec2 place, ImVec2 anchor, ImU32 colour, const std::string& text) {
  const ImVec2 size = textSize(font, text);
  const ImVec2 corner{std::round(place.x - anchor.x * size.x), std::round(place.y - anchor.y * size.y)};
  draw.AddText(font, font->FontSize, corner, colour, text.c_str(), text.c_str() + text.size());
  return {corner.x, corner.y, corner.x + size.x, corner.y + size.y};
}

void writeUpwards(ImDrawList& draw, ImFont* font, ImVec2 middle, ImU32 colour, const std::string& text) {
  // ImGui writes only level: its vertices are turned about the origin and moved into place. Text
  // outside the clip rectangle would be left out before that, so it is lifted for a moment.
  const int first = draw.VtxBuffer.Size;
  const ImVec2 size = textSize(font, text);
  draw.PushClipRect({-1e6F, -1e6F}, {1e6F, 1e6F});
  draw.AddText(font, font->FontSize, {0, 0}, colour, text.c_str(), text.c_str() + text.size());
  draw.PopClipRect();
  const ImVec2 origin{std::round(middle.x - 0.5F * size.y), std::round(middle.y + 0.5F * size.x)};
  for (int k = first; k < draw.VtxBuffer.Size; ++k) {
    const ImVec2 p = draw.VtxBuffer[k].pos;
    draw.VtxBuffer[k].pos = {origin.x + p.y, origin.y - p.x};
  }
}

void strokeLine(ImDrawList& draw, std::span<const ImVec2> points, ImU32 colour, float thickness, float dash) {
  if (points.size() < 2) return;
  const auto stroke = [&](std::span<const ImVec2> part) { strokeRun(draw, part, colour, thickness); };
  if (dash <= 0) return stroke(points);
  const float gap = 0.62F * dash;
  std::vector<ImVec2> part{points[0]};
  bool inked = true;
  float left = dash;  // of the present dash or gap
  for (std::size_t i = 1; i < points.size(); ++i) {
    ImVec2 at = points[i - 1];
    const ImVec2 to = points[i];
    float length = std::hypot(to.x - at.x, to.y - at.y);
    while (length > left) {
      at = {at.x + (to.x - at.x) * left / length, at.y + (to.y - at.y) * left / length};
      length -= left;
      if (inked) {
        part.push_back(at);
        stroke(part);
      }
      part.assign(1, at);
      inked = !inked;
      left = inked ? dash : gap;
    }
    left -= length;
    if (inked) part.push_back(to);
  }
  if (inked) stroke(part);
}

void drawMarker(ImDrawList& draw, ImVec2 centre, int shape, float radius, ImU32 colour) {
  const float rim = 0.28F * radius;
  if (shape % 4 == 0) {
    draw.AddCircleFilled(centre, radius + rim, paper::white);
    draw.AddCircleFilled(centre, radius, colour);
    return;
  }
  const std::vector<ImVec2> outer = markerCorners(centre, shape, radius + rim);
  const std::vector<ImVec2> inner = markerCorners(centre, shape, radius);
  draw.AddConvexPolyFilled(outer.data(), static_cast<int>(outer.size()), paper::white);
  draw.AddConvexPolyFilled(inner.data(), static_cast<int>(inner.size()), colour);
}

}  // namespace palpate::app
