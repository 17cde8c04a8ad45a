// The map of tools/mtled/atlas_page.h.
#include <algorithm>
#include <cmath>

#include "app/canvas.h"
#include "app/paper.h"
#include "mtled/atlas_page.h"
#include "mtled/case_result.h"

namespace palpate {
namespace {

constexpr float margin = 36, label_width = 560, cell_width = 186, cell_height = 74, gap = 6, title_height = 84, legend_height = 80;

struct Look {
  const char* letter;
  const char* name;
  ImU32 fill, ink;
};

/// Of a palette that the colour-blind can tell apart (Okabe and Ito 2008).
Look lookOf(const AtlasMeasure& m) {
  switch (outcomeOf(m)) {
    case AtlasOutcome::Stable: return {"S", "stable", IM_COL32(0, 158, 115, 255), paper::white};
    case AtlasOutcome::Refused: return {"R", "refused", IM_COL32(170, 176, 184, 255), paper::ink};
    case AtlasOutcome::Silent: return {"!", "silently wrong", IM_COL32(170, 20, 60, 255), paper::white};
    case AtlasOutcome::Degraded: break;
  }
  if (!std::isnan(m.lost_at)) return {"L", "lost after amber", IM_COL32(213, 130, 20, 255), paper::ink};
  return {"D", "degraded: amber", IM_COL32(247, 201, 88, 255), paper::ink};
}

/// What stands under the value: the deviation, or when it was lost.
std::string shortly(const AtlasMeasure& m) {
  if (!m.refused.empty()) return "refused";
  if (!std::isnan(m.lost_at)) return m.doubt + ", lost";
  std::string text = std::isnan(m.doubt_at) ? "" : m.doubt;
  if (m.compared.empty() || !std::isfinite(m.deviation)) return text;
  char share[32];
  const double percent = 100 * m.deviation;
  std::snprintf(share, sizeof share, std::abs(percent) < 0.05 ? "0 %%" : std::abs(percent) < 9.95 ? "%+.1f %%" : "%+.0f %%", percent);
  return text + (text.empty() ? "" : ", ") + share;
}

void drawSquare(ImDrawList& draw, const Theme& theme, const ImVec2& at, float width, const Look& look) {
  draw.AddRectFilled(at, {at.x + width, at.y + cell_height - gap}, look.fill, 6);
  writeText(draw, theme.body, {at.x + width - 9, at.y + 6}, {1, 0}, faded(look.ink, 0.75), look.letter);
}

}  // namespace

void writeAtlasFigure(const std::string& png, const Atlas& atlas, const std::vector<AtlasAxis>& axes) {
  std::vector<std::pair<const AtlasAxis*, std::vector<const AtlasRow*>>> lines;
  std::size_t longest = 0;
  for (const auto& axis : axes) {
    std::vector<const AtlasRow*> rows;
    for (const auto& row : atlas.rows)
      if (row.axis == axis.key) rows.push_back(&row);
    longest = std::max(longest, rows.size());
    if (!rows.empty()) lines.emplace_back(&axis, std::move(rows));
  }
  constexpr float legend_width = 5 * 330;
  const float width = 2 * margin + std::max(legend_width, label_width + cell_width * static_cast<float>(longest));
  const float height = 2 * margin + title_height + cell_height * static_cast<float>(lines.size()) + legend_height;

  Canvas canvas;
  ImDrawList& draw = canvas.begin(static_cast<int>(width), static_cast<int>(height));
  const Theme& theme = canvas.theme();
  writeText(draw, theme.title, {margin, margin}, {0, 0}, paper::ink, "Where Palpate's numbers are true");
  writeText(draw, theme.small, {width - margin, margin + 8}, {1, 0}, paper::faint, "percent: deviation from the truth of the row's table");
  float y = margin + title_height;
  for (const auto& [axis, rows] : lines) {
    writeText(draw, theme.body, {margin + label_width - 24, y + (cell_height - gap) / 2}, {1, 0.5F}, paper::ink, axis->title);
    float x = margin + label_width;
    for (const AtlasRow* row : rows) {
      const Look look = lookOf(row->measure);
      drawSquare(draw, theme, {x, y}, cell_width - gap, look);
      writeText(draw, theme.body, {x + 9, y + 6}, {0, 0}, look.ink, row->value);
      writeText(draw, theme.small, {x + 9, y + cell_height - gap - 7}, {0, 1}, look.ink, shortly(row->measure));
      x += cell_width;
    }
    y += cell_height;
  }
  y += legend_height - cell_height + gap;
  AtlasMeasure stable, degraded, lost, refused, silent;
  degraded.doubt_at = lost.doubt_at = 0;
  lost.lost_at = silent.lost_at = 1;
  refused.refused = "why";
  float x = margin;
  for (const auto* m : {&stable, &degraded, &lost, &refused, &silent}) {
    const Look look = lookOf(*m);
    drawSquare(draw, theme, {x, y}, 56, look);
    writeText(draw, theme.body, {x + 70, y + (cell_height - gap) / 2}, {0, 0.5F}, paper::ink, look.name);
    x += legend_width / 5;
  }
  writePng(png, canvas.end());
}

}  // namespace palpate
