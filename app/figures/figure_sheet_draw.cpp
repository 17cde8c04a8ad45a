// What a FigureSheet draws once everything has its place.
#include <algorithm>
#include <array>
#include <cmath>

#include "app/figures/figure_sheet.h"

namespace palpate::app {
namespace {

constexpr float marker_radius = 3.6F, line_width = 1.5F, dash = 6;  // units of length

}  // namespace

void FigureSheet::drawAxes() {
  const float tick_length = 4 * s_;
  for (const bool labelled : {false, true}) {  // the fine grid lies below the other
    for (const Tick& tick : x_.ticks) {
      if (tick.label.empty() == labelled) continue;
      const float x = std::round(static_cast<float>(x_.at(tick.value))) + 0.5F;
      draw_.AddLine({x, frame_.top}, {x, frame_.bottom}, labelled ? paper::grid : paper::fine_grid, 0.5F * s_);
      draw_.AddLine({x, frame_.bottom}, {x, frame_.bottom + (labelled ? tick_length : 0.6F * tick_length)},
                    paper::frame, 0.5F * s_);
      writeText(draw_, theme_.small, {x, frame_.bottom + 6 * s_}, {0.5F, 0}, paper::faint, tick.label);
    }
    for (const Tick& tick : y_.ticks) {
      if (tick.label.empty() == labelled) continue;
      const float y = std::round(static_cast<float>(y_.at(tick.value))) + 0.5F;
      draw_.AddLine({frame_.left, y}, {frame_.right, y}, labelled ? paper::grid : paper::fine_grid, 0.5F * s_);
      draw_.AddLine({frame_.left - (labelled ? tick_length : 0.6F * tick_length), y}, {frame_.left, y}, paper::frame,
                    0.5F * s_);
      writeText(draw_, theme_.small, {frame_.left - 6 * s_, y}, {1, 0.54F}, paper::faint, tick.label);
    }
  }
  for (const bool vertical : {false, true}) {  // where an axis passes zero, its line shows
    const Axis& axis = vertical ? x_ : y_;
    if (axis.log || !(axis.low < 0 && axis.high > 0)) continue;
    const float zero = std::round(static_cast<float>(axis.at(0))) + 0.5F;
    if (vertical)
      draw_.AddLine({zero, frame_.top}, {zero, frame_.bottom}, paper::frame, 0.5F * s_);
    else
      draw_.AddLine({frame_.left, zero}, {frame_.right, zero}, paper::frame, 0.5F * s_);
  }
  const float middle_x = 0.5F * (frame_.left + frame_.right), middle_y = 0.5F * (frame_.top + frame_.bottom);
  const float label_y = frame_.bottom + 6 * s_ + theme_.small->FontSize + 5 * s_;
  writeText(draw_, theme_.body, {middle_x, label_y}, {0.5F, 0}, paper::ink, figure_.x_label);
  if (!x_.factor.empty()) writeText(draw_, theme_.small, {frame_.right, label_y}, {1, 0}, paper::faint, x_.factor);
  if (!y_.factor.empty())
    writeText(draw_, theme_.small, {frame_.left, frame_.top - 3 * s_}, {0, 1}, paper::faint, y_.factor);
  writeUpwards(draw_, theme_.body, {sheet_.left + 12 * s_ + 0.5F * theme_.body->FontSize, middle_y}, paper::ink,
               figure_.y_label);
  writeText(draw_, theme_.title, {frame_.left, sheet_.top + 12 * s_}, {0, 0}, paper::ink, figure_.title);
}

void FigureSheet::drawBands() {
  for (const Band& band : figure_.bands) {
    const ImU32 colour = colourOf(band.colour);
    std::vector<ImVec2> low, high;
    for (std::size_t i = 0; i < band.x.size(); ++i) {
      low.push_back(at(band.x[i], band.low[i]));
      high.push_back(at(band.x[i], band.high[i]));
    }
    // Without soft edges neighbouring pieces meet exactly, so that no seams show.
    const ImDrawListFlags flags = draw_.Flags;
    draw_.Flags &= ~ImDrawListFlags_AntiAliasedFill;
    for (std::size_t i = 1; i < low.size(); ++i) {
      const float sum = low[i - 1].x + low[i - 1].y + high[i - 1].y + low[i].x + low[i].y + high[i].y;
      if (!std::isnan(sum)) draw_.AddQuadFilled(low[i - 1], high[i - 1], high[i], low[i], faded(colour, band_opacity_));
    }
    draw_.Flags = flags;
    if (band_opacity_ == 1) continue;
    for (const auto* edge : {&low, &high}) {
      std::vector<ImVec2> line;
      for (const ImVec2 p : *edge)
        if (!std::isnan(p.x + p.y)) line.push_back(p);
      strokeLine(draw_, line, faded(colour, 0.35), 0.5F * s_);
    }
  }
}

void FigureSheet::drawMarks() {
  for (const Mark& mark : figure_.marks) {
    const float p = std::round(static_cast<float>(mark.horizontal ? y_.at(mark.value) : x_.at(mark.value)));
    if (std::isnan(p)) continue;
    const std::array<ImVec2, 2> line = mark.horizontal ? std::array{ImVec2(frame_.left, p), ImVec2(frame_.right, p)}
                                                       : std::array{ImVec2(p, frame_.bottom), ImVec2(p, frame_.top)};
    strokeLine(draw_, line, colourOf(mark.colour), s_, 3.5F * s_);
  }
}

void FigureSheet::drawSeries() {
  for (std::size_t k = 0; k < figure_.series.size(); ++k)
    drawSeries(figure_.series[k], colourOf(colours_[k]), shapes_[k]);
}

void FigureSheet::drawSeries(const Series& series, ImU32 colour, int shape) {
  const auto lines = runs(series);
  const bool many = series.x.size() > 60 && series.style == SeriesStyle::LineAndPoints;
  const float radius = (many ? 0.7F : 1.0F) * marker_radius * s_;
  draw_.PushClipRect({frame_.left, frame_.top}, {frame_.right + 1, frame_.bottom + 1});
  if (hasLine(series.style))
    for (const auto& line : lines) {
      strokeLine(draw_, line, colour, line_width * s_, series.style == SeriesStyle::Dashed ? dash * s_ : 0);
      // A value between two breaks would not show at all.
      if (line.size() == 1) draw_.AddCircleFilled(line[0], line_width * s_, colour);
    }
  draw_.PopClipRect();
  // Points on the frame are whole; those beyond it are left out.
  const Box shown{frame_.left - 1, frame_.top - 1, frame_.right + 1, frame_.bottom + 1};
  for (const int i : series.highlighted) {
    if (i < 0 || static_cast<std::size_t>(i) >= series.x.size()) continue;
    const ImVec2 p = at(series.x[i], series.y[i]);
    if (!std::isnan(p.x + p.y) && shown.holds(p)) draw_.AddCircle(p, 2 * radius, colour, 0, 1.1F * s_);
  }
  if (hasPoints(series.style))
    for (const auto& line : lines)
      for (const ImVec2 p : line)
        if (shown.holds(p)) drawMarker(draw_, p, shape, radius, colour);
}

void FigureSheet::drawLegend() {
  const float row = 1.45F * theme_.small->FontSize;
  const auto drawEntry = [&](const Entry& entry, float left, float middle) {
    const ImU32 colour = colourOf(entry.colour);
    const float right = left + legend_sample * s_;
    if (entry.series == nullptr) {
      draw_.AddRectFilled({left, middle - 5 * s_}, {right, middle + 5 * s_}, faded(colour, band_opacity_));
      draw_.AddRect({left, middle - 5 * s_}, {right, middle + 5 * s_}, faded(colour, 0.35), 0, 0, 0.5F * s_);
    } else {
      const SeriesStyle style = entry.series->style;
      const std::array<ImVec2, 2> line = {ImVec2(left, middle), ImVec2(right, middle)};
      if (hasLine(style))
        strokeLine(draw_, line, colour, line_width * s_, style == SeriesStyle::Dashed ? dash * s_ : 0);
      if (hasPoints(style)) drawMarker(draw_, {0.5F * (left + right), middle}, entry.shape, marker_radius * s_, colour);
    }
    writeText(draw_, theme_.small, {right + legend_gap * s_, middle}, {0, 0.54F}, paper::ink, entry.label);
  };
  if (legend_inside_) {
    draw_.AddRectFilled({legend_.left, legend_.top}, {legend_.right, legend_.bottom}, faded(paper::white, 0.92),
                        3 * s_);
    draw_.AddRect({legend_.left, legend_.top}, {legend_.right, legend_.bottom}, paper::grid, 3 * s_, 0, 0.5F * s_);
    float middle = legend_.top + 0.6F * legend_pad * s_ + 0.5F * row;
    for (const Entry& entry : entries_) {
      drawEntry(entry, legend_.left + legend_pad * s_, middle);
      middle += row;
    }
    return;
  }
  float left = frame_.left;
  float middle =
      frame_.top - (y_.factor.empty() ? 0 : theme_.small->FontSize + 3 * s_) - legendRowsHeight() + 0.5F * row;
  for (const Entry& entry : entries_) {
    const float width = legendWidth(entry) + 18 * s_;
    if (left > frame_.left && left + width > frame_.left + frame_.width()) {
      left = frame_.left;
      middle += row;
    }
    drawEntry(entry, left, middle);
    left += width;
  }
}

}  // namespace palpate::app
