#include "app/figures/figure_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate::app {
namespace {

// Okabe and Ito, "Color universal design" (2008): told apart with any common colour blindness.
constexpr std::array<ImU32, figure_colour_count> palette = {IM_COL32(0, 114, 178, 255), IM_COL32(213, 94, 0, 255),
                                                            IM_COL32(0, 158, 115, 255), IM_COL32(204, 121, 167, 255),
                                                            IM_COL32(230, 159, 0, 255), IM_COL32(86, 180, 233, 255)};

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
    // A colour that comes again gets another marker.
    const int index = std::max(0, colours_.back());
    const auto sameBefore = [&](const Entry& e) {
      return e.series != nullptr && e.colour == colours_.back() && hasPoints(e.series->style);
    };
    shapes_.push_back(index + (hasPoints(series.style)
                                   ? static_cast<int>(std::count_if(entries_.begin(), entries_.end(), sameBefore))
                                   : 0));
    if (!series.label.empty()) entries_.push_back({&series, colours_.back(), shapes_.back(), series.label});
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
    if (mark.horizontal)
      ry.add(mark.value, figure_.log_y);
    else
      rx.add(mark.value, figure_.log_x);
  }
  rx = aired(rx, figure_.log_x, points || figure_.log_x ? 0.05 : 0.02);
  ry = aired(ry, figure_.log_y, 0.07);

  ImFont* const small = theme_.small;
  const float unit = small->FontSize;
  frame_.top =
      sheet_.top + 12 * s_ + (figure_.title.empty() ? 6 * s_ : theme_.title->FontSize + 12 * s_) + legend_height;
  frame_.bottom =
      sheet_.bottom - 12 * s_ - unit - 6 * s_ - (figure_.x_label.empty() ? 0 : theme_.body->FontSize + 6 * s_);
  y_ = axisOver(figure_.y_low.value_or(ry.low), figure_.y_high.value_or(ry.high), figure_.log_y,
                static_cast<int>(frame_.height() / (3.2F * unit)), theme_.has_greek);
  if (band_opacity_ == 1) std::erase_if(y_.ticks, [](const Tick& tick) { return tick.value > 0 && tick.value < 1; });
  float widest = 0;
  for (const Tick& tick : y_.ticks) widest = std::max(widest, textSize(small, tick.label).x);
  frame_.left = std::round(sheet_.left + 12 * s_ + (figure_.y_label.empty() ? 0 : theme_.body->FontSize + 8 * s_) +
                           widest + 6 * s_);
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
      if (hasLine(series.style))
        takeLine(run);
      else
        for (const ImVec2 p : run) take(p);
    }
  for (const Band& band : figure_.bands)
    for (const std::vector<double>* edge : {&band.low, &band.high}) {
      std::vector<ImVec2> line;
      for (std::size_t i = 0; i < band.x.size(); ++i) line.push_back(at(band.x[i], (*edge)[i]));
      takeLine(line);
    }
  for (const Mark& mark : figure_.marks) {
    const float p = static_cast<float>(mark.horizontal ? y_.at(mark.value) : x_.at(mark.value));
    if (mark.horizontal)
      takeLine({{frame_.left, p}, {frame_.right, p}});
    else
      takeLine({{p, frame_.bottom}, {p, frame_.top}});
  }
}

/// Writes into the first choice that is inside the frame and meets neither another label nor data.
bool FigureSheet::place(const std::vector<Box>& choices, ImU32 colour, const std::string& text) {
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
      for (const float left :
           {frame_.right - gap - size.x, frame_.left + gap, 0.5F * (frame_.left + frame_.right - size.x)})
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
  for (const ImVec2 corner :
       {ImVec2(right, top), ImVec2(left, top), ImVec2(right, bottom), ImVec2(left, bottom), ImVec2(middle_x, top),
        ImVec2(middle_x, bottom), ImVec2(right, middle_y), ImVec2(left, middle_y)}) {
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

}  // namespace palpate::app
