#include "app/panels/plot.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/figures/round_ticks.h"
#include "app/render/theme.h"

namespace palpate::app {

namespace {

/// The drawing area of a plot and the map from data to pixels.
struct Frame {
  ImDrawList* draw = nullptr;
  ImVec2 min, max;  // px
  PlotAxes axes;

  float x(double value) const {
    return min.x + static_cast<float>((value - axes.x_min) / (axes.x_max - axes.x_min)) * (max.x - min.x);
  }
  float y(double value) const {
    return max.y - static_cast<float>((value - axes.y_min) / (axes.y_max - axes.y_min)) * (max.y - min.y);
  }
};

double stepOf(const std::vector<double>& ticks) { return ticks.size() < 2 ? 1 : ticks[1] - ticks[0]; }

ImVec2 textSize(const std::string& s) { return ImGui::CalcTextSize(s.c_str(), s.c_str() + s.size()); }

/// Takes the room of a plot from the window and draws ground, grid, ticks and labels.
/// The y axis gets labels only where `y_ticks` asks for them.
Frame beginPlot(const char* id, float height, const PlotAxes& axes, bool y_ticks) {
  const float unit = ImGui::GetFontSize();
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const ImVec2 size{std::max(4 * unit, ImGui::GetContentRegionAvail().x), std::max(5 * unit, height)};
  ImGui::PushID(id);
  ImGui::Dummy(size);
  ImGui::PopID();

  Frame frame;
  frame.draw = ImGui::GetWindowDrawList();
  frame.axes = axes;
  const auto rows = roundTicks(axes.y_min, axes.y_max, std::max(2, static_cast<int>(size.y / (2.6F * unit))));
  const double row_step = stepOf(rows);
  float label_width = 0;
  if (y_ticks)
    for (double value : rows) label_width = std::max(label_width, textSize(tickLabel(value, row_step)).x);
  frame.min = {std::round(origin.x + label_width + 0.5F * unit), std::round(origin.y + 1.35F * unit)};
  frame.max = {std::round(origin.x + size.x - 0.5F * unit), std::round(origin.y + size.y - 1.5F * unit)};
  ImDrawList& draw = *frame.draw;
  draw.AddRectFilled(frame.min, frame.max, colours::plot_ground, 0.2F * unit);

  if (y_ticks)
    for (double value : rows) {
      const float y = std::round(frame.y(value));
      const std::string label = tickLabel(value, row_step);
      draw.AddLine({frame.min.x, y}, {frame.max.x, y}, colours::grid);
      draw.AddText({frame.min.x - textSize(label).x - 0.35F * unit, y - 0.5F * unit}, colours::faint, label.c_str());
    }
  const auto columns = roundTicks(axes.x_min, axes.x_max, std::max(2, static_cast<int>(size.x / (5 * unit))));
  const double column_step = stepOf(columns);
  const float x_label_begin = frame.max.x - textSize(axes.x_label).x;
  for (double value : columns) {
    const float x = std::round(frame.x(value));
    const std::string label = tickLabel(value, column_step);
    const float width = textSize(label).x;
    draw.AddLine({x, frame.min.y}, {x, frame.max.y}, colours::grid);
    const float left = std::max(origin.x, x - 0.5F * width);
    if (left + width + 0.4F * unit < x_label_begin)  // the axis' own label stands at the right end
      draw.AddText({left, frame.max.y + 0.3F * unit}, colours::faint, label.c_str());
  }
  draw.AddText({x_label_begin, frame.max.y + 0.3F * unit}, colours::faint, axes.x_label);
  draw.AddText({origin.x, origin.y}, colours::faint, axes.y_label);
  return frame;
}

void endPlot(const Frame& frame) {
  frame.draw->AddRect(frame.min, frame.max, colours::frame, 0.2F * ImGui::GetFontSize());
}

/// Marks the point of a curve that is nearest to the pointer, and says its values.
void drawCursor(const Frame& frame, std::span<const PlotSeries> series) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  if (!ImGui::IsWindowHovered() || mouse.x < frame.min.x || mouse.x > frame.max.x || mouse.y < frame.min.y ||
      mouse.y > frame.max.y)
    return;
  const float unit = ImGui::GetFontSize();
  float least = 9 * unit * unit;
  const PlotPoint* nearest = nullptr;
  const PlotSeries* curve = nullptr;
  for (const PlotSeries& one : series)
    for (const PlotPoint& point : one.points) {
      const float dx = frame.x(point.x) - mouse.x, dy = frame.y(point.y) - mouse.y;
      if (!(dx * dx + dy * dy < least)) continue;
      least = dx * dx + dy * dy;
      nearest = &point;
      curve = &one;
    }
  if (nearest == nullptr) return;
  const ImVec2 at{frame.x(nearest->x), frame.y(nearest->y)};
  frame.draw->AddLine({at.x, frame.min.y}, {at.x, frame.max.y}, colours::frame);
  frame.draw->AddLine({frame.min.x, at.y}, {frame.max.x, at.y}, colours::frame);
  frame.draw->AddCircleFilled(at, 0.33F * unit, curve->colour);
  const std::string name = curve->label[0] != '\0' ? std::string(curve->label) + ": " : std::string();
  ImGui::SetTooltip("%s%.3g %s, %.3f N", name.c_str(), static_cast<double>(nearest->x), frame.axes.x_label,
                    static_cast<double>(nearest->y));
}

}  // namespace

void drawPlot(const char* id, float height, const PlotAxes& axes, std::span<const PlotSeries> series) {
  const Frame frame = beginPlot(id, height, axes, true);
  const float unit = ImGui::GetFontSize();
  ImDrawList& draw = *frame.draw;

  if (axes.y_min < 0 && axes.y_max > 0) {
    const float zero = std::round(frame.y(0));
    draw.AddLine({frame.min.x, zero}, {frame.max.x, zero}, colours::frame);
  }
  draw.PushClipRect(frame.min, frame.max, true);
  for (const PlotSeries& one : series) {
    if (one.points.empty()) continue;
    ImVec2 last{frame.x(one.points[0].x), frame.y(one.points[0].y)};
    draw.PathClear();
    draw.PathLineTo(last);
    for (std::size_t i = 1; i < one.points.size(); ++i) {
      const ImVec2 p{frame.x(one.points[i].x), frame.y(one.points[i].y)};
      const bool apart = std::abs(p.x - last.x) >= 1 || std::abs(p.y - last.y) >= 1;
      if (!apart && i + 1 < one.points.size()) continue;
      draw.PathLineTo(p);
      last = p;
    }
    draw.PathStroke(one.colour, 0, one.thickness * unit / 12);
    draw.AddCircleFilled(last, 0.22F * unit, one.colour);
  }
  draw.PopClipRect();
  drawCursor(frame, series);

  // The legend stands above the frame, at its right end.
  float right = frame.max.x;
  for (std::size_t k = series.size(); k-- > 0;) {
    if (series[k].label[0] == '\0') continue;
    right -= ImGui::CalcTextSize(series[k].label).x;
    draw.AddText({right, frame.min.y - 1.35F * unit}, colours::text, series[k].label);
    right -= 1.3F * unit;
    draw.AddLine({right, frame.min.y - 0.75F * unit}, {right + unit, frame.min.y - 0.75F * unit}, series[k].colour,
                 0.16F * unit);
    right -= 0.7F * unit;
  }
  endPlot(frame);
}

void drawHistogram(const char* id, float height, const PlotAxes& axes, std::span<const float> counts, ImU32 colour,
                   std::span<const PlotMark> marks) {
  float largest = 1;
  for (float count : counts) largest = std::max(largest, count);
  PlotAxes scaled = axes;
  scaled.y_min = 0;
  scaled.y_max = 1.05 * std::log10(1 + largest);
  const Frame frame = beginPlot(id, height, scaled, false);
  const float unit = ImGui::GetFontSize();
  ImDrawList& draw = *frame.draw;

  draw.PushClipRect(frame.min, frame.max, true);
  const double width = (axes.x_max - axes.x_min) / static_cast<double>(std::max<std::size_t>(1, counts.size()));
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] <= 0) continue;
    const float left = frame.x(axes.x_min + static_cast<double>(k) * width);
    const float right = frame.x(axes.x_min + static_cast<double>(k + 1) * width);
    draw.AddRectFilled({left, frame.y(std::log10(1 + counts[k]))}, {std::max(left + 1, right - 1), frame.max.y},
                       colour);
  }
  std::array<float, 3> free_from;  // per row of labels; a label takes the first row with room
  free_from.fill(frame.min.x);
  for (const PlotMark& mark : marks) {
    if (!(mark.x >= axes.x_min && mark.x <= axes.x_max)) continue;
    const float x = std::round(frame.x(mark.x));
    draw.AddLine({x, frame.min.y}, {x, frame.max.y}, mark.colour, 0.1F * unit);
    const float label_width = ImGui::CalcTextSize(mark.label).x;
    float left = x + 0.3F * unit;
    if (left + label_width > frame.max.x) left = x - 0.3F * unit - label_width;
    for (std::size_t k = 0; k < free_from.size(); ++k) {
      if (left < free_from[k]) continue;
      const float top = frame.min.y + (0.2F + static_cast<float>(k)) * unit;
      draw.AddRectFilled({left - 1, top}, {left + label_width + 1, top + unit}, colours::plot_ground);
      draw.AddText({left, top}, mark.colour, mark.label);
      free_from[k] = left + label_width + 0.3F * unit;
      break;
    }
  }
  draw.PopClipRect();
  endPlot(frame);
}

}  // namespace palpate::app
