#include "mtled/pictures/atlas_map.h"

#include <algorithm>
#include <cmath>

#include "app/figures/canvas.h"
#include "app/figures/paper.h"
#include "base/number_text.h"

namespace palpate::tools {
namespace {

namespace paper = app::paper;
using app::faded;
using app::textSize;
using app::Theme;
using app::writeText;

// px
constexpr float margin = 48, cell_height = 70, gap = 6, padding = 12, row_height = cell_height + gap;
constexpr float heading_height = 176;  // title, what is in it, legend
constexpr float row_width = 4000;      // an axis with more squares goes on in the next row

struct Look {
  const char* letter;
  const char* name;
  ImU32 fill, ink;
};

/// Of hues that the colour-blind can tell apart (Okabe and Ito 2008), light enough for dark text.
Look lookOf(const AtlasMeasure& m) {
  switch (outcomeOf(m)) {
    case AtlasOutcome::Stable:
      return {"S", "stable", IM_COL32(122, 205, 177, 255), paper::ink};
    case AtlasOutcome::Refused:
      return {"R", "refused", IM_COL32(209, 213, 219, 255), paper::ink};
    case AtlasOutcome::Silent:
      return {"!", "silently wrong", IM_COL32(170, 20, 60, 255), paper::white};
    case AtlasOutcome::Degraded:
      break;
  }
  if (!std::isnan(m.lost_at)) return {"L", "lost after amber", IM_COL32(230, 149, 68, 255), paper::ink};
  return {"D", "degraded: amber", IM_COL32(250, 216, 126, 255), paper::ink};
}

/// What stands under the value: the doubt, and the deviation or that it was lost.
std::string shortly(const AtlasMeasure& m) {
  if (!m.refused.empty()) return "refused";
  if (!std::isnan(m.lost_at)) return m.doubt + ", lost";
  std::string text = std::isnan(m.doubt_at) ? "" : m.doubt;
  if (m.compared.empty() || !std::isfinite(m.deviation)) return text;
  const double percent = 100 * m.deviation;
  const std::string share = format(std::abs(percent) < 0.05   ? "0 %%"
                                   : std::abs(percent) < 9.95 ? "%+.1f %%"
                                                              : "%+.0f %%",
                                   percent);
  return text + (text.empty() ? "" : ", ") + share;
}

/// A row of the map.
struct Line {
  const AtlasAxis* axis;
  std::vector<const AtlasRow*> rows;
};

std::vector<Line> linesOf(const Atlas& atlas, const std::vector<AtlasAxis>& axes) {
  std::vector<Line> lines;
  for (const auto& axis : axes) {
    Line line{&axis, {}};
    for (const auto& row : atlas.rows)
      if (row.axis == axis.key) line.rows.push_back(&row);
    if (!line.rows.empty()) lines.push_back(std::move(line));
  }
  return lines;
}

/// Each look, from right to wrong.
std::vector<Look> allLooks() {
  AtlasMeasure stable, degraded, lost, refused, silent;
  degraded.doubt_at = lost.doubt_at = 0;
  lost.lost_at = silent.lost_at = 1;
  refused.refused = "why";
  return {lookOf(stable), lookOf(degraded), lookOf(lost), lookOf(refused), lookOf(silent)};
}

float letterWidth(const Theme& theme) { return textSize(theme.small, "S").x + padding; }

/// The widest text decides, so that none leaves its square.
float cellWidth(const Theme& theme, const std::vector<Line>& lines) {
  float widest = 0;
  for (const auto& line : lines)
    for (const AtlasRow* row : line.rows)
      widest = std::max({widest, textSize(theme.body, row->value).x + letterWidth(theme),
                         textSize(theme.small, shortly(row->measure)).x});
  return widest + 2 * padding;
}

void drawSquare(ImDrawList& draw, const Theme& theme, ImVec2 at, float width, float height, const Look& look) {
  draw.AddRectFilled(at, {at.x + width, at.y + height}, look.fill, 8);
  writeText(draw, theme.small, {at.x + width - padding, at.y + 8}, {1, 0}, faded(look.ink, 0.65), look.letter);
}

/// @return where it ends
float drawLegend(ImDrawList& draw, const Theme& theme, ImVec2 at) {
  constexpr float width = 44, height = 36;
  for (const Look& look : allLooks()) {
    drawSquare(draw, theme, at, width, height, look);
    at.x = writeText(draw, theme.small, {at.x + width + padding, at.y + height / 2}, {0, 0.5F}, paper::ink, look.name)
               .right +
           40;
  }
  return at.x - 40;
}

/// @return the sheet's size that it needs
ImVec2 drawMap(ImDrawList& draw, const Theme& theme, const Atlas& atlas, const std::vector<AtlasAxis>& axes) {
  const auto number = [&](AtlasOutcome outcome) { return std::to_string(atlas.count(outcome)); };
  const std::string about = std::to_string(atlas.rows.size()) + " cells: " + number(AtlasOutcome::Stable) +
                            " stable, " + number(AtlasOutcome::Degraded) + " degraded with amber first, " +
                            number(AtlasOutcome::Refused) + " refused, " + number(AtlasOutcome::Silent) +
                            " silently wrong. Percent: deviation from the truth that the row's table names.";
  const float title =
      writeText(draw, theme.title, {margin, margin - 12}, {0, 0}, paper::ink, "Where Palpate's numbers are true").right;
  const float subtitle = writeText(draw, theme.small, {margin, margin + 40}, {0, 0}, paper::faint, about).right;
  const float legend = drawLegend(draw, theme, {margin, margin + 86});

  const std::vector<Line> lines = linesOf(atlas, axes);
  const float cell_width = cellWidth(theme, lines);
  float labels = 0;
  for (const auto& line : lines) labels = std::max(labels, textSize(theme.body, line.axis->title).x);
  const float left = margin + labels + 28;
  float right = std::max({title, subtitle, legend}), y = margin + heading_height;
  for (const auto& line : lines) {
    writeText(draw, theme.body, {margin + labels, y + cell_height / 2}, {1, 0.5F}, paper::ink, line.axis->title);
    float x = left;
    for (const AtlasRow* row : line.rows) {
      if (x > left && x + cell_width > row_width) {
        x = left;
        y += row_height;
      }
      const Look look = lookOf(row->measure);
      drawSquare(draw, theme, {x, y}, cell_width, cell_height, look);
      writeText(draw, theme.body, {x + padding, y + 6}, {0, 0}, look.ink, row->value);
      writeText(draw, theme.small, {x + padding, y + cell_height - 8}, {0, 1}, look.ink, shortly(row->measure));
      right = std::max(right, x + cell_width);
      x += cell_width + gap;
    }
    y += row_height;
  }
  return {right + margin, y - gap + margin};
}

}  // namespace

app::Picture drawAtlasMap(app::Canvas& canvas, const Atlas& atlas, const std::vector<AtlasAxis>& axes) {
  const ImVec2 size = drawMap(canvas.begin(1, 1), canvas.theme(), atlas, axes);  // the texts' sizes decide
  canvas.end();
  drawMap(canvas.begin(static_cast<int>(size.x), static_cast<int>(size.y)), canvas.theme(), atlas, axes);
  return canvas.end();
}

}  // namespace palpate::tools
