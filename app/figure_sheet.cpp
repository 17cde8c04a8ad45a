#include "app/figure_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

// Okabe and Ito, "Color universal design" (2008): told apart with any common colour blindness.
constexpr std::array<ImU32, figure_colour_count> palette = {
    IM_COL32(0, 114, 178, 255),   IM_COL32(213, 94, 0, 255),   IM_COL32(0, 158, 115, 255),
    IM_COL32(204, 121, 167, 255), IM_COL32(230, 159, 0, 255),  IM_COL32(86, 180, 233, 255)};

constexpr float marker_radius = 3.6F, line_width = 1.5F, dash = 6;  // units of length
constexpr float legend_sample = 20, legend_gap = 6, legend_pad = 7;

bool hasLine(SeriesStyle style) { return style != SeriesStyle::Points; }
bool hasPoints(SeriesStyle style) { return style == SeriesStyle::Points || style == SeriesStyle::LineAndPoints; }

Box boxAt(ImVec2 corner, ImVec2 size) { return {corner.x, corner.y, corner.x + size.x, corner.y + size.y}; }

}  // namespace

FigureSheet::FigureSheet(ImDrawList& draw, const Theme& theme, const Figure& figure, int width, int height)
    : draw_(draw),
      theme_(theme),
      figure_(figure),
      sheet_{0, 0, static_cast<float>(width), static_cast<float>(height)},
      s_(theme.scale) {
  int next = 0;
  for (const Series& series : figure.series) {
    colours_.push_back(series.colour == next_colour ? next++ % figure_colour_count : series.colour);
    const int shape = std::max(0, colours_.back());
    if (!series.label.empty()) entries_.push_back({&series, colours_.back(), shape, series.label});
  }
  for (const Band& band : figure.bands)
    if (!band.label.empty()) entries_.push_back({nullptr, band.colour, 0, band.label});
}

ImU32 FigureSheet::colourOf(int index) const {
  return index < 0 ? paper::ink : palette[static_cast<std::size_t>(index) % palette.size()];
}

ImVec2 FigureSheet::at(double x, double y) const {
  // Far outside the frame a place only has to be far: line joints would overflow.
  const auto near = [](double px) { return std::isnan(px) ? px : std::clamp(px, -1e5, 1e5); };
  return {static_cast<float>(near(x_.at(x))), static_cast<float>(near(y_.at(y)))};
}

/// The parts of a series without a break, as drawn.
std::vector<std::vector<ImVec2>> FigureSheet::runs(const Series& series) const {
  std::vector<std::vector<ImVec2>> all(1);
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const ImVec2 p = at(series.x[i], series.y[i]);
    if (std::isnan(p.x) || std::isnan(p.y)) {
      if (!all.back().empty()) all.emplace_back();
      continue;
    }
    std::vector<ImVec2>& run = all.back();
    if (series.style == SeriesStyle::Step && !run.empty()) run.push_back({p.x, run.back().y});
    // What is nearer than half a pixel adds nothing but joints.
    const bool apart = run.empty() || std::abs(p.x - run.back().x) + std::abs(p.y - run.back().y) >= 0.5F;
    if (apart || hasPoints(series.style)) run.push_back(p);
  }
  return all;
}

void FigureSheet::layOut(float legend_height) {
  Range rx, ry;
  bool points = false;
  for (const Series& series : figure_.series) {
    points = points || hasPoints(series.style);
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (std::isnan(series.y[i]) || (figure_.log_y && series.y[i] <= 0)) continue;
      rx.add(series.x[i], figure_.log_x);
      ry.add(series.y[i], figure_.log_y);
    }
  }
  for (const Band& band : figure_.bands)
    for (std::size_t i = 0; i < band.x.size(); ++i) {
      rx.add(band.x[i], figure_.log_x);
      ry.add(band.low[i], figure_.log_y);
      ry.add(band.high[i], figure_.log_y);
    }
  for (const Mark& mark : figure_.marks) {
    if (mark.horizontal) ry.add(mark.value, figure_.log_y);
    else rx.add(mark.value, figure_.log_x);
  }
  rx = aired(rx, figure_.log_x, points || figure_.log_x ? 0.05 : 0.02);
  ry = aired(ry, figure_.log_y, 0.07);

  ImFont* const small = theme_.small;
  const float unit = small->FontSize;
  frame_.top = sheet_.top + 12 * s_ + (figure_.title.empty() ? 6 * s_ : theme_.title->FontSize + 12 * s_) + legend_height;
  frame_.bottom = sheet_.bottom - 12 * s_ - unit - 6 * s_ - (figure_.x_label.empty() ? 0 : theme_.body->FontSize + 6 * s_);
  y_ = axisOver(figure_.y_low.value_or(ry.low), figure_.y_high.value_or(ry.high), figure_.log_y,
                static_cast<int>(frame_.height() / (3.2F * unit)), theme_.has_greek);
  if (band_opacity_ == 1) std::erase_if(y_.ticks, [](const Tick& tick) { return tick.value > 0 && tick.value < 1; });
  float widest = 0;
  for (const Tick& tick : y_.ticks) widest = std::max(widest, textSize(small, tick.label).x);
  frame_.left = std::round(sheet_.left + 12 * s_ + (figure_.y_label.empty() ? 0 : theme_.body->FontSize + 8 * s_) + widest + 6 * s_);
  frame_.right = sheet_.right - 22 * s_;
  x_ = axisOver(figure_.x_low.value_or(rx.low), figure_.x_high.value_or(rx.high), figure_.log_x,
                static_cast<int>(frame_.width() / (5.5F * unit)), theme_.has_greek);
  if (!y_.factor.empty()) frame_.top += unit + 3 * s_;
  frame_.top = std::round(frame_.top);
  frame_.bottom = std::round(frame_.bottom);
  x_.begin = frame_.left;
  x_.end = frame_.right;
  y_.begin = frame_.bottom;
  y_.end = frame_.top;
}

void FigureSheet::takePlaces() {
  inked_.clear();
  labels_.clear();
  const float spacing = 5 * s_;
  const auto take = [&](ImVec2 p) {
    if (frame_.holds(p)) inked_.push_back(p);
  };
  const auto takeLine = [&](const std::vector<ImVec2>& line) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      take(line[i]);
      if (i == 0) continue;
      const ImVec2 a = line[i - 1], b = line[i];
      const int parts = std::min(1000, static_cast<int>(std::hypot(b.x - a.x, b.y - a.y) / spacing));
      for (int k = 1; k < parts; ++k) {
        const float t = static_cast<float>(k) / static_cast<float>(parts);
        take({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
      }
    }
  };
  for (const Series& series : figure_.series)
    for (const auto& run : runs(series)) {
      if (hasLine(series.style)) takeLine(run);
      else for (const ImVec2 p : run) take(p);
    }
  for (const Band& band : figure_.bands)
    for (const std::vector<double>* edge : {&band.low, &band.high}) {
      std::vector<ImVec2> line;
      for (std::size_t i = 0; i < band.x.size(); ++i) line.push_back(at(band.x[i], (*edge)[i]));
      takeLine(line);
    }
  for (const Mark& mark : figure_.marks) {
    const float p = static_cast<float>(mark.horizontal ? y_.at(mark.value) : x_.at(mark.value));
    if (mark.horizontal) takeLine({{frame_.left, p}, {frame_.right, p}});
    else takeLine({{p, frame_.bottom}, {p, frame_.top}});
  }
}

/// Writes into the first choice that is inside the frame and meets neither another label nor data.
bool FigureSheet::place(std::vector<Box> choices, ImU32 colour, const std::string& text) {
  for (const Box& box : choices) {
    const bool free = frame_.holds(box) &&
                      std::none_of(labels_.begin(), labels_.end(), [&](const Label& l) { return l.box.meets(box); }) &&
                      covered(box) == 0;
    if (!free) continue;
    labels_.push_back({box, colour, text});
    return true;
  }
  return false;
}

void FigureSheet::placePointLabels() {
  for (std::size_t k = 0; k < figure_.series.size(); ++k) {
    const Series& series = figure_.series[k];
    // The highlighted points' names come first: where room is short, the others go without.
    std::vector<std::size_t> order;
    for (const int i : series.highlighted) order.push_back(i);
    for (std::size_t i = 0; i < series.point_labels.size(); ++i)
      if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
    for (const std::size_t i : order) {
      if (i >= series.point_labels.size() || series.point_labels[i].empty()) continue;
      const ImVec2 p = at(series.x[i], series.y[i]);
      if (std::isnan(p.x) || std::isnan(p.y) || !frame_.holds(p)) continue;
      const ImVec2 size = textSize(theme_.small, series.point_labels[i]);
      const bool ringed = std::count(series.highlighted.begin(), series.highlighted.end(), static_cast<int>(i)) > 0;
      const float away = (ringed ? 11 : 7) * s_, near = (ringed ? 7 : 4) * s_;
      place({boxAt({p.x + away, p.y - 0.5F * size.y}, size), boxAt({p.x + near, p.y - near - size.y}, size),
             boxAt({p.x + near, p.y + near}, size), boxAt({p.x - 0.5F * size.x, p.y - away - size.y}, size),
             boxAt({p.x - 0.5F * size.x, p.y + away}, size), boxAt({p.x - away - size.x, p.y - 0.5F * size.y}, size),
             boxAt({p.x - near - size.x, p.y - near - size.y}, size), boxAt({p.x - near - size.x, p.y + near}, size)},
            paper::faint, series.point_labels[i]);
    }
  }
}

void FigureSheet::placeMarkLabels() {
  const float gap = 4 * s_;
  for (const Mark& mark : figure_.marks) {
    if (mark.label.empty()) continue;
    const ImVec2 size = textSize(theme_.small, mark.label);
    std::vector<Box> choices;
    if (mark.horizontal) {
      const float y = static_cast<float>(y_.at(mark.value));
      if (!(y >= frame_.top && y <= frame_.bottom)) continue;
      for (const float left : {frame_.right - gap - size.x, frame_.left + gap, 0.5F * (frame_.left + frame_.right - size.x)})
        for (const float top : {y - gap - size.y, y + gap}) choices.push_back(boxAt({left, top}, size));
    } else {
      const float x = static_cast<float>(x_.at(mark.value));
      if (!(x >= frame_.left && x <= frame_.right)) continue;
      for (int row = 0; row < 6; ++row)
        for (const float left : {x + gap, x - gap - size.x})
          choices.push_back(boxAt({left, frame_.top + gap + static_cast<float>(row) * 1.25F * size.y}, size));
    }
    // A mark without its name would mean nothing: where nothing is free, it covers data.
    if (!place(choices, colourOf(mark.colour), mark.label))
      labels_.push_back({choices.front(), colourOf(mark.colour), mark.label});
  }
}

double FigureSheet::covered(const Box& box) const {
  const Box wide{box.left - 3 * s_, box.top - 2 * s_, box.right + 3 * s_, box.bottom + 2 * s_};
  return static_cast<double>(std::count_if(inked_.begin(), inked_.end(), [&](ImVec2 p) { return wide.holds(p); }));
}

float FigureSheet::legendWidth(const Entry& entry) const {
  return (legend_sample + legend_gap) * s_ + textSize(theme_.small, entry.label).x;
}

/// True where a place inside the frame covers no data.
bool FigureSheet::findLegendPlace() {
  float width = 0;
  for (const Entry& entry : entries_) width = std::max(width, legendWidth(entry));
  const float row = 1.45F * theme_.small->FontSize, air = 8 * s_;
  const ImVec2 size{width + 2 * legend_pad * s_, row * static_cast<float>(entries_.size()) + 1.2F * legend_pad * s_};
  const float left = frame_.left + air, right = frame_.right - air - size.x;
  const float top = frame_.top + air, bottom = frame_.bottom - air - size.y;
  const float middle_x = 0.5F * (left + right), middle_y = 0.5F * (top + bottom);
  for (const ImVec2 corner : {ImVec2(right, top), ImVec2(left, top), ImVec2(right, bottom), ImVec2(left, bottom),
                              ImVec2(middle_x, top), ImVec2(middle_x, bottom), ImVec2(right, middle_y), ImVec2(left, middle_y)}) {
    const Box box = boxAt(corner, size);
    bool free = frame_.holds(box) && covered(box) == 0;
    for (const Label& label : labels_) free = free && !label.box.meets(box);
    if (!free) continue;
    legend_ = box;
    return true;
  }
  return false;
}

/// Of the legend above the frame, in as many rows as it takes.
float FigureSheet::legendRowsHeight() const {
  float rows = 1, used = 0;
  for (const Entry& entry : entries_) {
    const float width = legendWidth(entry) + 18 * s_;
    if (used > 0 && used + width > frame_.width()) {
      ++rows;
      used = 0;
    }
    used += width;
  }
  return rows * 1.45F * theme_.small->FontSize + 3 * s_;
}

void FigureSheet::draw() {
  const auto arrange = [&](float legend_height) {
    layOut(legend_height);
    takePlaces();
    placeMarkLabels();
    placePointLabels();
  };
  arrange(0);
  legend_inside_ = entries_.empty() || findLegendPlace();
  if (!legend_inside_) arrange(legendRowsHeight());

  drawAxes();
  draw_.PushClipRect({frame_.left, frame_.top}, {frame_.right + 1, frame_.bottom + 1});
  drawBands();
  drawMarks();
  draw_.PopClipRect();
  drawSeries();
  draw_.AddRect({frame_.left, frame_.top}, {frame_.right + 1, frame_.bottom + 1}, paper::frame, 0, 0, 0.6F * s_);
  for (const Label& label : labels_) {
    draw_.AddRectFilled({label.box.left - 1, label.box.top}, {label.box.right + 1, label.box.bottom},
                        faded(paper::white, 0.8));
    writeText(draw_, theme_.small, {label.box.left, label.box.top}, {0, 0}, label.colour, label.text);
  }
  if (!entries_.empty()) drawLegend();
}

void FigureSheet::drawAxes() {
  const float tick_length = 4 * s_;
  for (const bool labelled : {false, true}) {  // the fine grid lies below the other
    for (const Tick& tick : x_.ticks) {
      if (tick.label.empty() == labelled) continue;
      const float x = std::round(static_cast<float>(x_.at(tick.value))) + 0.5F;
      draw_.AddLine({x, frame_.top}, {x, frame_.bottom}, labelled ? paper::grid : paper::fine_grid, 0.5F * s_);
      draw_.AddLine({x, frame_.bottom}, {x, frame_.bottom + (labelled ? tick_length : 0.6F * tick_length)}, paper::frame, 0.5F * s_);
      writeText(draw_, theme_.small, {x, frame_.bottom + 6 * s_}, {0.5F, 0}, paper::faint, tick.label);
    }
    for (const Tick& tick : y_.ticks) {
      if (tick.label.empty() == labelled) continue;
      const float y = std::round(static_cast<float>(y_.at(tick.value))) + 0.5F;
      draw_.AddLine({frame_.left, y}, {frame_.right, y}, labelled ? paper::grid : paper::fine_grid, 0.5F * s_);
      draw_.AddLine({frame_.left - (labelled ? tick_length : 0.6F * tick_length), y}, {frame_.left, y}, paper::frame, 0.5F * s_);
      writeText(draw_, theme_.small, {frame_.left - 6 * s_, y}, {1, 0.54F}, paper::faint, tick.label);
    }
  }
  for (const bool vertical : {false, true}) {  // where an axis passes zero, its line shows
    const Axis& axis = vertical ? x_ : y_;
    if (axis.log || !(axis.low < 0 && axis.high > 0)) continue;
    const float zero = std::round(static_cast<float>(axis.at(0))) + 0.5F;
    if (vertical) draw_.AddLine({zero, frame_.top}, {zero, frame_.bottom}, paper::frame, 0.5F * s_);
    else draw_.AddLine({frame_.left, zero}, {frame_.right, zero}, paper::frame, 0.5F * s_);
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
    const std::array<ImVec2, 2> line = mark.horizontal
                                           ? std::array{ImVec2(frame_.left, p), ImVec2(frame_.right, p)}
                                           : std::array{ImVec2(p, frame_.bottom), ImVec2(p, frame_.top)};
    strokeLine(draw_, line, colourOf(mark.colour), s_, 3.5F * s_);
  }
}

void FigureSheet::drawSeries() {
  for (std::size_t k = 0; k < figure_.series.size(); ++k)
    drawSeries(figure_.series[k], colourOf(colours_[k]), std::max(0, colours_[k]));
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
      if (hasLine(style)) strokeLine(draw_, line, colour, line_width * s_, style == SeriesStyle::Dashed ? dash * s_ : 0);
      if (hasPoints(style)) drawMarker(draw_, {0.5F * (left + right), middle}, entry.shape, marker_radius * s_, colour);
    }
    writeText(draw_, theme_.small, {right + legend_gap * s_, middle}, {0, 0.54F}, paper::ink, entry.label);
  };
  if (legend_inside_) {
    draw_.AddRectFilled({legend_.left, legend_.top}, {legend_.right, legend_.bottom}, faded(paper::white, 0.92), 3 * s_);
    draw_.AddRect({legend_.left, legend_.top}, {legend_.right, legend_.bottom}, paper::grid, 3 * s_, 0, 0.5F * s_);
    float middle = legend_.top + 0.6F * legend_pad * s_ + 0.5F * row;
    for (const Entry& entry : entries_) {
      drawEntry(entry, legend_.left + legend_pad * s_, middle);
      middle += row;
    }
    return;
  }
  float left = frame_.left;
  float middle = frame_.top - (y_.factor.empty() ? 0 : theme_.small->FontSize + 3 * s_) - legendRowsHeight() + 0.5F * row;
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

}  // namespace palpate
