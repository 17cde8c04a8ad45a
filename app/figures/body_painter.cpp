#include "app/figures/body_painter.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "app/figures/canvas.h"
#include "app/figures/figure_axis.h"
#include "app/figures/figure_writer.h"
#include "app/figures/paper.h"
#include "app/render/field.h"
#include "app/render/renderer.h"

namespace palpate::app {
namespace {

constexpr double narrow_fov_deg = 22;         // a long lens: parallel edges stay nearly parallel
constexpr float margin = 22, bar_width = 15;  // units of length
constexpr float feature_cosine = 0.77F;       // rest edges that turn by more than 40 degrees are drawn

/// A camera that shows all positions in a part of the picture, as large as fits and in its middle.
Camera cameraAround(const std::vector<Vec3f>& positions, double azimuth_deg, double elevation_deg, const Box& part,
                    int width, int height) {
  Camera camera;
  camera.azimuth_deg = azimuth_deg;
  camera.elevation_deg = elevation_deg;
  camera.fov_deg = narrow_fov_deg;
  Eigen::AlignedBox3d box;
  for (const Vec3f& x : positions) box.extend(x.cast<double>());
  if (box.isEmpty()) return camera;
  camera.frame(box.center(), std::max(1e-6, 0.5 * box.diagonal().norm()), width, height);
  // Perspective makes this implicit; each round leaves about a tenth of the misfit.
  for (int round = 0; round < 6; ++round) {
    Eigen::AlignedBox2d seen;
    for (const Vec3f& x : positions)
      seen.extend(Eigen::Vector2d(camera.project(x.cast<double>(), width, height).head<2>()));
    const Eigen::Vector2d middle = seen.center();
    camera.pan(0.5 * (part.left + part.right) - middle.x(), 0.5 * (part.top + part.bottom) - middle.y(), height);
    camera.distance *= std::max(seen.sizes().x() / part.width(), seen.sizes().y() / part.height());
  }
  return camera;
}

/// Edges of the outline of a surface as the eye sees it: where it turns away, and where it has an
/// edge, or ends (along a cut), and faces the eye.
std::vector<std::array<int, 2>> outline(const TriangleSurface& surface, const Vec3& eye) {
  struct Sides {
    std::array<Vec3, 2> normal;
    int count = 0;
    bool front = false, back = false;
  };
  std::map<std::array<int, 2>, Sides> edges;
  for (const auto& t : surface.triangles) {
    const Vec3& a = surface.vertices[t[0]];
    const Vec3 normal = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).normalized();
    const bool faces_eye = normal.dot(eye - a) > 0;
    for (int c = 0; c < 3; ++c) {
      Sides& sides = edges[{std::min(t[c], t[(c + 1) % 3]), std::max(t[c], t[(c + 1) % 3])}];
      if (sides.count < 2) sides.normal[sides.count++] = normal;
      (faces_eye ? sides.front : sides.back) = true;
    }
  }
  std::vector<std::array<int, 2>> drawn;
  for (const auto& [edge, sides] : edges) {
    const bool turns_away = sides.front && sides.back;
    const bool feature = sides.count == 1 || sides.normal[0].dot(sides.normal[1]) < feature_cosine;
    if (turns_away || (feature && sides.front)) drawn.push_back(edge);
  }
  return drawn;
}

void drawRestOutline(ImDrawList& draw, const TriangleSurface& surface, const Camera& camera, int width, int height,
                     float s) {
  const auto place = [&](int v) {
    const Vec3 p = camera.project(surface.vertices[v], width, height);
    return ImVec2(static_cast<float>(p.x()), static_cast<float>(p.y()));
  };
  for (const auto& [a, b] : outline(surface, camera.eye())) draw.AddLine(place(a), place(b), paper::frame, 0.7F * s);
}

void drawColourBar(ImDrawList& draw, const Theme& theme, const Box& bar, ColourMap map, const Axis& axis,
                   const std::string& label) {
  const float s = theme.scale;
  const int rows = static_cast<int>(bar.height());
  for (int k = 0; k < rows; ++k) {
    const Vec3f c = colourOf(map, 1 - (k + 0.5) / rows);
    const float y = bar.top + static_cast<float>(k);
    draw.AddRectFilled({bar.left, y}, {bar.right, y + 1}, ImGui::ColorConvertFloat4ToU32({c.x(), c.y(), c.z(), 1}));
  }
  draw.AddRect({bar.left, bar.top}, {bar.right, bar.bottom}, paper::frame, 0, 0, 0.5F * s);
  float widest = 0;
  for (const Tick& tick : axis.ticks) {
    const float y = std::round(static_cast<float>(axis.at(tick.value)));
    draw.AddLine({bar.right, y}, {bar.right + 4 * s, y}, paper::frame, 0.5F * s);
    const Box box = writeText(draw, theme.small, {bar.right + 7 * s, y}, {0, 0.54F}, paper::ink, tick.label);
    widest = std::max(widest, box.width());
  }
  if (!axis.factor.empty())
    writeText(draw, theme.small, {bar.left, bar.top - 5 * s}, {0, 1}, paper::faint, axis.factor);
  writeUpwards(draw, theme.body,
               {bar.right + 7 * s + widest + 7 * s + 0.5F * theme.body->FontSize, 0.5F * (bar.top + bar.bottom)},
               paper::ink, label);
}

/// From the least to the largest value; from 0 where none is negative; evenly about 0 where the
/// colours part in the middle.
Range fieldRange(const std::vector<float>& values, bool diverging) {
  Range range;
  for (const float value : values) range.add(value, false);
  if (range.empty) return {0, 1, false};
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  if (diverging)
    range = {-largest, largest, false};
  else
    range.low = std::min(0.0, range.low);
  if (!(range.high > range.low)) range.high = range.low + 1;
  return range;
}

}  // namespace

BodyPainter::BodyPainter(FigureWriter& writer, const Body& model, const std::optional<CutPlane>& cut)
    : writer_(writer),
      cut_(cut ? std::make_unique<const Body>(cutBody(model, *cut)) : nullptr),
      model_(cut_ ? *cut_ : model),
      renderer_(std::make_unique<Renderer>(model_, findShaderDir())) {}

BodyPainter::~BodyPainter() = default;

DrawnBody BodyPainter::draw(const BodyPicture& picture, const AlignedVector<Float4>& u, int width, int height) {
  const auto require = [&](std::size_t count, const char* what) {
    if (count != model_.X.size())
      throw std::invalid_argument("picture '" + picture.title + "': " + std::to_string(count) + " " + what + " for " +
                                  std::to_string(model_.X.size()) + " nodes");
  };
  if (!u.empty()) require(u.size(), "displacements");
  if (picture.field) require(picture.field->values.size(), "field values");

  const Theme& theme = writer_.canvas().theme();
  const float s = theme.scale;
  const bool bar_shown = picture.field || picture.colour != ColourMap::Tissue;
  const float top = margin * s + (picture.title.empty() ? 0 : theme.title->FontSize + 4 * s);
  const Box part{margin * s, top, static_cast<float>(width) - (bar_shown ? 115 : margin) * s,
                 static_cast<float>(height) - margin * s};
  std::vector<Vec3f> positions = deformed(model_.skin.surface.vertices, model_.skin, u);
  if (picture.rest_outline)
    for (const Vec3& X : model_.skin.surface.vertices) positions.push_back(X.cast<float>());

  Snapshot snapshot;
  snapshot.u = u;
  if (picture.tool) snapshot.tools.set(0, {*picture.tool, 0}, {});
  View view;
  view.camera = cameraAround(positions, picture.azimuth_deg, picture.elevation_deg, part, width, height);
  view.light_azimuth_deg = picture.azimuth_deg;
  view.colour_map = picture.colour;
  view.show_room = view.show_fixed = view.show_forces = false;
  view.show_tool = picture.tool.has_value();
  if (picture.field) {
    view.node_values = &picture.field->values;
    view.colour_map = picture.field->diverging ? ColourMap::J : ColourMap::Displacement;
    const Range range = fieldRange(skinAverages(model_, picture.field->values), picture.field->diverging);
    view.colour_min = range.low;
    view.colour_max = range.high;
  } else {
    const ColourScale scale = automaticScale(
        skinValues(model_, u, deformed(model_.skin.surface.vertices, model_.skin, u), picture.colour),
        picture.colour);
    view.colour_min = scale.min;
    view.colour_max = scale.max;
  }
  view.colour_auto = false;
  view.colour_min = picture.low.value_or(view.colour_min);
  view.colour_max = picture.high.value_or(view.colour_max);
  if (!(view.colour_max > view.colour_min))
    throw std::invalid_argument("picture '" + picture.title + "': its colours' range is empty");

  ImDrawList& list = writer_.canvas().begin(width, height);
  renderer_->draw(snapshot, view, width, height);
  if (picture.rest_outline) drawRestOutline(list, model_.skin.surface, view.camera, width, height, s);
  if (!picture.title.empty()) writeText(list, theme.title, {margin * s, 12 * s}, {0, 0}, paper::ink, picture.title);
  if (bar_shown) {
    ColourUnit unit{"", 1};
    std::string label;
    if (picture.field) {
      label = picture.field->label;
    } else {
      unit = unitOf(picture.colour, std::max(std::abs(view.colour_min), std::abs(view.colour_max)));
      label = quantityName(picture.colour);
      if (unit.name[0] != '\0') label += std::string(", ") + unit.name;
    }
    const float middle = 0.5F * (part.top + part.bottom), half = 0.32F * part.height();
    const Box bar{std::round(part.right + 14 * s), std::round(middle - half),
                  std::round(part.right + (14 + bar_width) * s), std::round(middle + half)};
    Axis axis = axisOver(view.colour_min * unit.per_si, view.colour_max * unit.per_si, false, 7, theme.has_greek);
    axis.begin = bar.bottom;
    axis.end = bar.top;
    drawColourBar(list, theme, bar, view.colour_map, axis, label);
  }
  return {writer_.canvas().end(), view.camera, view.colour_min, view.colour_max};
}

void BodyPainter::write(const std::string& png, const BodyPicture& picture, const AlignedVector<Float4>& u, int width,
                        int height) {
  writePng(png, draw(picture, u, width, height).picture);
}

}  // namespace palpate::app
