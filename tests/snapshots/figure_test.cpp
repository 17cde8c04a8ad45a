// Figures and body pictures for printed pages: what stands where, by the colours of pixels.
#include "app/figures/figure_writer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "app/figures/body_painter.h"
#include "app/render/colour_map.h"
#include "app/render/field.h"
#include "snapshots/hand_made_model.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::app;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
const Eigen::Vector3i white(255, 255, 255), blue(0, 114, 178), vermilion(213, 94, 0), green(0, 158, 115);

Eigen::Vector3i colourAt(const Picture& picture, double x, double y) {
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  if (column < 0 || row < 0 || column >= picture.width || row >= picture.height) FAIL("outside the picture");
  const std::size_t k = 3 * (static_cast<std::size_t>(row) * picture.width + column);
  return {picture.rgb[k], picture.rgb[k + 1], picture.rgb[k + 2]};
}

bool near(const Eigen::Vector3i& a, const Eigen::Vector3i& b, int tolerance = 12) {
  return (a - b).cwiseAbs().maxCoeff() <= tolerance;
}

bool drawnAt(const DrawnFigure& drawn, double x, double y, const Eigen::Vector3i& colour) {
  return near(colourAt(drawn.picture, drawn.x.at(x), drawn.y.at(y)), colour);
}

/// Pixels of this colour in a rectangle.
int countOf(const Picture& picture, double left, double top, double right, double bottom,
            const Eigen::Vector3i& colour) {
  int count = 0;
  for (double y = std::ceil(top); y < bottom; ++y)
    for (double x = std::ceil(left); x < right; ++x) count += near(colourAt(picture, x, y), colour);
  return count;
}

int countOf(const Picture& picture, const Eigen::Vector3i& colour) {
  return countOf(picture, 0, 0, picture.width, picture.height, colour);
}

std::vector<std::string> labelsOf(const Axis& axis) {
  std::vector<std::string> labels;
  for (const Tick& tick : axis.ticks)
    if (!tick.label.empty()) labels.push_back(tick.label);
  return labels;
}

using Labels = std::vector<std::string>;

Series line(std::vector<double> x, std::vector<double> y, SeriesStyle style = SeriesStyle::Line) {
  Series series;
  series.x = std::move(x);
  series.y = std::move(y);
  series.style = style;
  return series;
}

}  // namespace

TEST_CASE("An axis puts values where they belong and has round ticks", "[figure]") {
  Axis axis = axisOver(0, 10, false, 5);
  axis.begin = 100;
  axis.end = 300;
  CHECK(axis.at(0) == 100);
  CHECK(axis.at(2.5) == 150);
  CHECK(labelsOf(axis) == Labels{"0", "2", "4", "6", "8", "10"});
  CHECK(std::isnan(axis.at(not_a_number)));

  Axis log = axisOver(0.01, 100, true, 10);
  log.begin = 400;
  log.end = 0;
  CHECK(log.at(0.01) == Approx(400));
  CHECK(log.at(1) == Approx(200));
  CHECK(log.at(std::sqrt(10)) == Approx(150));
  CHECK(labelsOf(log) == Labels{"0.01", "0.1", "1", "10", "100"});
  CHECK(log.ticks.size() == 4 * 9 + 1);
  CHECK(std::isnan(log.at(0)));
  CHECK(std::isnan(log.at(-1)));
}

TEST_CASE("Labels stay short: powers, factors, twos and fives, skipped decades", "[figure]") {
  CHECK(labelsOf(axisOver(1e-6, 1e-4, true, 4)) == Labels{"10\u207b\u2076", "10\u207b\u2075", "10\u207b\u2074"});
  CHECK(labelsOf(axisOver(1e-6, 1e-4, true, 4, false)) == Labels{"1e-6", "1e-5", "1e-4"});
  CHECK(labelsOf(axisOver(1, 10, true, 9)) == Labels{"1", "2", "5", "10"});
  CHECK(labelsOf(axisOver(1e-12, 1, true, 5)).size() <= 5);
  const Axis tiny = axisOver(-2e-5, 2e-5, false, 4);
  CHECK(tiny.factor == "\u00d710\u207b\u2076");
  CHECK(labelsOf(tiny) == Labels{"\u221220", "\u221210", "0", "10", "20"});
  CHECK(axisOver(0, 50, false, 5).factor.empty());
}

TEST_CASE("The range has air, keeps zero where it is near, and is never empty", "[figure]") {
  const auto range = [](double low, double high, bool log) { return aired({low, high, false}, log, 0.05); };
  CHECK(range(0, 10, false).low == 0);
  CHECK(range(0, 10, false).high == Approx(10.5));
  CHECK(range(1, 10, false).low == 0);  // a tenth of the axis is a small price
  CHECK(range(8, 10, false).low == Approx(7.9));
  CHECK(range(-10, -1, false).high == 0);
  CHECK(range(3, 3, false).low < 3);
  CHECK(range(0, 0, false).high > 0);
  CHECK(range(3, 3, true).low > 0);
  for (const double value : {1.1, 3.0, 7.7}) {
    const Range wide = range(value, 1.01 * value, true);
    CHECK(wide.low < value);
    CHECK(wide.high > 1.01 * value);
    CHECK(labelsOf(axisOver(wide.low, wide.high, true, 9)).size() >= 2);
  }
  Range none;
  none.add(not_a_number, false);
  none.add(-1, true);
  CHECK(none.empty);
  CHECK(aired(none, true, 0.05).low > 0);
}

TEST_CASE("Curves pass through their data, in the palette's order, and break at NaN", "[figure]") {
  FigureWriter writer;
  Figure figure;
  figure.x_label = "x";
  figure.y_label = "y";
  figure.series = {line({0, 1, 2, 3, 4}, {0, 1, 2, 3, 4}), line({0, 1, 2, 3, 4}, {4, 4, not_a_number, 4, 4})};
  const DrawnFigure drawn = writer.draw(figure, 800, 500);
  CHECK(drawn.picture.width == 800);
  CHECK(drawn.picture.height == 500);
  for (const double x : {0.5, 1.3, 2.0, 3.7}) CHECK(drawnAt(drawn, x, x, blue));
  CHECK_FALSE(drawnAt(drawn, 1, 2, blue));
  CHECK(drawnAt(drawn, 0.5, 4, vermilion));
  CHECK(drawnAt(drawn, 3.5, 4, vermilion));
  CHECK_FALSE(drawnAt(drawn, 1.5, 4, vermilion));  // on both sides of the missing point
  CHECK_FALSE(drawnAt(drawn, 2.5, 4, vermilion));
  CHECK(near(colourAt(drawn.picture, 2, 2), white));
  CHECK(drawn.y.begin > drawn.y.end);  // up is up
  // Nothing is drawn outside the frame but labels in grey.
  CHECK(countOf(drawn.picture, blue) ==
        countOf(drawn.picture, drawn.x.begin, drawn.y.end, drawn.x.end, drawn.y.begin, blue));
}

TEST_CASE("Logarithmic axes put decades evenly and leave out what has no logarithm", "[figure]") {
  FigureWriter writer;
  Figure figure;
  figure.log_x = figure.log_y = true;
  figure.series = {line({0.1, 1, 10, 100}, {1e-4, 1e-3, 1e-2, 1e-1}),
                   line({0.1, 1, 10, 100}, {0.05, -1, 0, 0.05}, SeriesStyle::Points)};
  const DrawnFigure drawn = writer.draw(figure, 800, 500);
  CHECK(drawn.x.at(1) - drawn.x.at(0.1) == Approx(drawn.x.at(100) - drawn.x.at(10)));
  CHECK(drawnAt(drawn, std::sqrt(10), 1e-3 * std::sqrt(10), blue));  // a power law is straight
  CHECK(drawnAt(drawn, 0.1, 0.05, vermilion));
  CHECK(drawnAt(drawn, 100, 0.05, vermilion));
  CHECK_FALSE(drawnAt(drawn, 10, drawn.y.low * 1.01, vermilion));
}

TEST_CASE("Steps are level from each point to the next, bands fill what lies between", "[figure]") {
  FigureWriter writer;
  Figure figure;
  figure.series = {line({0, 2, 4}, {4, 2, 0}, SeriesStyle::Step)};
  figure.bands = {{"", {0, 4}, {3, 3}, {3.5, 3.5}, 2}};
  const DrawnFigure drawn = writer.draw(figure, 800, 500);
  CHECK(drawnAt(drawn, 1, 4, blue));
  CHECK(drawnAt(drawn, 2, 3, blue));
  CHECK(drawnAt(drawn, 3, 2, blue));
  CHECK_FALSE(drawnAt(drawn, 1, 3, blue));
  const Eigen::Vector3i tint = (white.cast<double>() + 0.16 * (green - white).cast<double>()).cast<int>();
  CHECK(drawnAt(drawn, 0.77, 3.25, tint));
  CHECK_FALSE(drawnAt(drawn, 0.77, 2.7, tint));
}

TEST_CASE("The legend stands where there are no data, or above the frame", "[figure]") {
  FigureWriter writer;
  Figure figure;
  figure.series = {line({0, 1}, {0, 1})};
  figure.series[0].label = "rising";
  const auto inked = [](const DrawnFigure& d) {
    return countOf(d.picture, d.x.begin, d.y.end, d.x.end, d.y.begin, blue);
  };
  const DrawnFigure inside = writer.draw(figure, 800, 500);
  figure.series[0].label = "";
  const DrawnFigure without = writer.draw(figure, 800, 500);
  CHECK(inside.y.end == without.y.end);   // it takes no room
  CHECK(inked(inside) > inked(without));  // its sample stands in the frame, and covers no data
  // Zigzags all over: no free place is left inside.
  Series zigzag;
  for (int k = 0; k < 200; ++k) {
    zigzag.x.push_back(k);
    zigzag.y.push_back(k % 2);
  }
  figure.series = {zigzag};
  const DrawnFigure bare = writer.draw(figure, 800, 500);
  figure.series[0].label = "zigzag";
  const DrawnFigure above = writer.draw(figure, 800, 500);
  CHECK(above.y.end > bare.y.end);
  CHECK(countOf(above.picture, 0, 0, 800, above.y.end, blue) > 20);
}

TEST_CASE("Marks cross the frame, points carry names, highlighted ones a ring", "[figure]") {
  FigureWriter writer;
  Figure figure;
  figure.series = {line({1, 2, 3}, {3, 1, 2}, SeriesStyle::Points)};
  const DrawnFigure plain = writer.draw(figure, 800, 500);
  figure.series[0].highlighted = paretoFront(figure.series[0].x, figure.series[0].y);
  CHECK(figure.series[0].highlighted == std::vector<int>{0, 1});
  const DrawnFigure ringed = writer.draw(figure, 800, 500);
  const auto around = [](const DrawnFigure& d, double x, double y) {
    return countOf(d.picture, d.x.at(x) - 20, d.y.at(y) - 20, d.x.at(x) + 20, d.y.at(y) + 20, blue);
  };
  CHECK(around(ringed, 1, 3) > around(plain, 1, 3) + 20);
  CHECK(around(ringed, 3, 2) == around(plain, 3, 2));
  figure.marks = {{"limit", 1.5, true, 1}, {"", 2.5, false, 2}};
  const DrawnFigure marked = writer.draw(figure, 800, 500);
  CHECK(countOf(marked.picture, marked.x.begin, marked.y.at(1.5) - 2, marked.x.end, marked.y.at(1.5) + 2, vermilion) >
        200);
  CHECK(countOf(marked.picture, marked.x.at(2.5) - 2, marked.y.end, marked.x.at(2.5) + 2, marked.y.begin, green) > 100);
  figure.series[0].point_labels = {"a", "b"};
  CHECK_THROWS_WITH(writer.draw(figure), Catch::Contains("lengths"));
}

TEST_CASE("A Pareto front holds what nothing else beats in both", "[figure]") {
  CHECK(paretoFront({3, 1, 2, 2, 4}, {1, 5, 2, 3, 1}) == std::vector<int>{1, 2, 0});
  CHECK(paretoFront({1, 2}, {not_a_number, 3}) == std::vector<int>{1});
  CHECK(paretoFront({}, {}).empty());
}

TEST_CASE("A histogram counts every finite value and shows single ones", "[figure]") {
  std::vector<double> values(1000, 0.05);
  values.push_back(1.0);
  values.push_back(0.0);
  values.push_back(not_a_number);
  Histogram histogram = histogramOf(values, 10);
  CHECK(histogram.counts.size() == 10);
  CHECK(histogram.counts.front() == 1001);
  CHECK(histogram.counts.back() == 1);  // the largest belongs to the last bin
  FigureWriter writer;
  const DrawnFigure drawn = writer.draw(histogram, 800, 500);
  CHECK(drawnAt(drawn, 0.05, 500, blue));
  CHECK(drawnAt(drawn, 0.95, 0.9, blue));
  CHECK_FALSE(drawnAt(drawn, 0.95, 2, blue));
  CHECK_FALSE(drawnAt(drawn, 0.5, 0.9, blue));
  CHECK(labelsOf(drawn.y).front() == "1");
  CHECK(histogramOf({}, 4).counts == std::vector<double>(4, 0.0));
}

TEST_CASE("Equal figures give equal pictures, whatever was drawn between - files hold them", "[figure]") {
  const TempFolder folder;
  FigureWriter writer;
  Figure figure;
  figure.title = "Title";
  figure.series = {line({0, 1, 2}, {0, 1, 4}, SeriesStyle::LineAndPoints)};
  const DrawnFigure first = writer.draw(figure, 640, 400);
  writer.draw(Figure{}, 300, 200);  // without data: an empty frame
  writer.write(folder.path("figure.png"), figure, 640, 400);
  CHECK(readPng(folder.path("figure.png")).rgb == first.picture.rgb);
  CHECK_THROWS_WITH(writer.write(folder.path("missing/figure.png"), figure), Catch::Contains("missing/figure.png"));
}

namespace {

Model organ() { return handMadeModel(ellipsoidSurface(Vec3(0.07, 0.05, 0.035), 3), 0.012, ToolShape{}); }

Eigen::Vector3i barColour(ColourMap map, double t) { return (255 * colourOf(map, t)).array().round().cast<int>(); }

}  // namespace

TEST_CASE("A body is framed as it is deformed, on white, with a bar for its colours", "[figure]") {
  FigureWriter writer;
  const Model model = organ();
  BodyPainter painter(writer, model);
  AlignedVector<Float4> u(model.X.size());
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = toFloat4(Vec3(0, 0, 0.3 + 2 * model.X[i].z()));  // far away, stretched
  BodyPicture picture;
  picture.title = "Stretched";
  picture.rest_outline = false;
  const int width = 700, height = 500;
  const DrawnBody drawn = painter.draw(picture, u, width, height);
  CHECK(near(colourAt(drawn.picture, 1, height - 2), white));
  int inside = 0;
  Eigen::AlignedBox2d seen;
  for (const Vec3f& x : deformed(model.skin.surface.vertices, model.skin, u)) {
    const Eigen::Vector2d p = drawn.camera.project(x.cast<double>(), width, height).head<2>();
    seen.extend(p);
    inside += p.x() > 0 && p.x() < width && p.y() > 0 && p.y() < height;
  }
  CHECK(inside == static_cast<int>(model.skin.surface.vertices.size()));
  CHECK(std::max(seen.sizes().x() / width, seen.sizes().y() / height) > 0.6);  // and it is no speck
  CHECK_FALSE(near(colourAt(drawn.picture, seen.center().x(), seen.center().y()), white));
  CHECK(countOf(drawn.picture, seen.max().x() + 5, 0, width, height, barColour(ColourMap::Displacement, 0.03)) > 20);
  CHECK(countOf(drawn.picture, seen.max().x() + 5, 0, width, height, barColour(ColourMap::Displacement, 0.97)) > 20);
}

TEST_CASE("A node field's colours can be read off its bar", "[figure]") {
  FigureWriter writer;
  const Model model = organ();
  BodyPainter painter(writer, model);
  BodyPicture picture;
  picture.rest_outline = false;
  picture.low = 0;
  picture.high = 4;
  const int width = 700, height = 500;
  const auto labOf = [](const Eigen::Vector3i& c) { return Vec3f(c.cast<float>() / 255); };
  for (const double value : {1.0, 2.0, 3.5}) {
    picture.field = NodeField{std::vector<float>(model.X.size(), static_cast<float>(value)), "Error, mm", false};
    const DrawnBody drawn = painter.draw(picture, {}, width, height);
    CHECK(drawn.low == 0);
    CHECK(drawn.high == 4);
    const Vec3 top = drawn.camera.project(Vec3(0, 0, 0.035), width, height);
    // Nearest of all colours of the bar, by the colour at the body's top: light and shade may move it a little.
    const Vec3f shown = labOf(colourAt(drawn.picture, top.x(), top.y() + 3));
    double best = 0, least = 1e9;
    for (double t = 0; t <= 1; t += 0.01) {
      const double distance = (shown - colourOf(ColourMap::Displacement, t)).norm();
      if (distance < least) {
        least = distance;
        best = 4 * t;
      }
    }
    INFO("value " << value << " reads as " << best);
    CHECK(std::abs(best - value) < 0.3);  // 8 % of the bar
  }
  picture.low.reset();
  picture.high.reset();
  const DrawnBody automatic = painter.draw(picture, {}, width, height);
  CHECK(automatic.low == 0);
  CHECK(automatic.high == Approx(3.5));
  picture.field->values.pop_back();
  CHECK_THROWS_WITH(painter.draw(picture, {}, width, height), Catch::Contains("nodes"));
}

TEST_CASE("The outline at rest stays where the body was", "[figure]") {
  FigureWriter writer;
  const Model model = organ();
  BodyPainter painter(writer, model);
  BodyPicture picture;
  picture.colour = ColourMap::Tissue;
  AlignedVector<Float4> u(model.X.size(), Float4{0, 0, -0.05F, 0});
  const int width = 700, height = 500;
  const DrawnBody with = painter.draw(picture, u, width, height);
  const Vec3 centre = with.camera.project(Vec3::Zero(), width, height);
  const double left = centre.x() - 150, right = centre.x() + 150;
  const auto upperDark = [&](const DrawnBody& d) {  // dark pixels above the body's former centre
    int count = 0;
    for (double y = 0; y < centre.y() - 20; ++y)
      for (double x = left; x < right; ++x) count += colourAt(d.picture, x, y).maxCoeff() < 200;
    return count;
  };
  CHECK(upperDark(with) > 100);
  picture.rest_outline = false;
  AlignedVector<Float4> low = u;
  const DrawnBody without = painter.draw(picture, low, width, height);
  CHECK(without.camera.target.z() < with.camera.target.z());  // then the former place needs no room
}
