#include "app/trainer/score_page.h"

#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "app/figures/paper.h"
#include "app/figures/round_ticks.h"
#include "app/render/framebuffer.h"
#include "base/number_text.h"

namespace palpate::app {

namespace {

// A4 at 150 dots per inch.
constexpr int page_width = 1240, page_height = 1754, map_height = 1010;
constexpr double key_height = 55;  // px, half of what the key below the map takes
constexpr float margin = 90, line = 37, text_px = 23, small_px = 19, title_px = 40;
constexpr std::size_t most_lumps = 6;  // listed one by one

// Of Okabe and Ito (2008), which every eye tells apart.
constexpr ImU32 hit_colour = IM_COL32(0, 114, 178, 255), false_colour = IM_COL32(213, 94, 0, 255);

/// What is written and drawn on the page, over the map.
class Page {
 public:
  explicit Page(const Theme& theme) : font_(theme.big), list_(ImGui::GetDrawListSharedData()) {
    list_._ResetForNewFrame();
    list_.PushClipRect({0, 0}, {page_width, page_height});
    list_.PushTextureID(ImGui::GetIO().Fonts->TexID);
  }

  ImDrawList& list() { return list_; }

  float width(const std::string& text, float px) const {
    return font_->CalcTextSizeA(px, 1e9F, 0, text.c_str(), text.c_str() + text.size()).x;
  }
  /// @param anchor  0: from x on, 1: up to x
  void write(float x, float y, const std::string& text, float px = text_px, ImU32 colour = paper::ink,
             float anchor = 0) {
    list_.AddText(font_, px, {std::round(x - anchor * width(text, px)), std::round(y)}, colour, text.c_str());
  }
  /// Over as many lines as it takes.
  void writeWrapped(float y, const std::string& text, float px, ImU32 colour) {
    list_.AddText(font_, px, {margin, y}, colour, text.c_str(), text.c_str() + text.size(), page_width - 2 * margin);
  }
  void rule(float y) { list_.AddLine({margin, y}, {page_width - margin, y}, paper::frame, 1.5F); }
  /// A name and its value, in one of two columns.
  void row(int column, float y, const std::string& name, const std::string& value, bool bad = false) {
    const float half = 0.5F * (page_width - 2 * margin), gap = 28;
    const float left = margin + static_cast<float>(column) * half + (column > 0 ? gap : 0);
    write(left, y, name, text_px, paper::faint);
    write(margin + static_cast<float>(column + 1) * half - (column > 0 ? 0 : gap), y, value, text_px,
          bad ? false_colour : paper::ink, 1);
  }

  void render() {
    ImDrawList* lists[] = {&list_};
    ImDrawData data;
    data.Valid = true;
    data.CmdLists = lists;
    data.CmdListsCount = 1;
    data.TotalVtxCount = list_.VtxBuffer.Size;
    data.TotalIdxCount = list_.IdxBuffer.Size;
    data.DisplaySize = {page_width, page_height};
    data.FramebufferScale = {1, 1};
    ImGui_ImplOpenGL3_RenderDrawData(&data);
  }

 private:
  ImFont* font_;
  ImDrawList list_;
};

std::string plural(int count, const char* one, const char* several) {
  return format("%d %s", count, count == 1 ? one : several);
}

/// Seen along the tool's way, as the trainee's hand comes.
Camera fromTheTool(const Model& model, const OrganView& view) {
  const Vec3 eye = -model.scene.tools[0].direction;
  Camera camera;
  camera.elevation_deg = std::clamp(std::asin(std::clamp(eye.z(), -1.0, 1.0)) * 180 / std::numbers::pi, -89.0, 89.0);
  camera.azimuth_deg = eye.head<2>().norm() > 0.1 ? std::atan2(eye.y(), eye.x()) * 180 / std::numbers::pi : -90;
  camera.fov_deg = 20;  // nearly parallel: what is measured in the picture is nearly true
  camera.frame(view.centre(), 0.99 * view.radius(), page_width, map_height);
  camera.pan(0, -key_height, map_height);
  return camera;
}

void writeHead(Page& page, const SheetHead& head, const TaskScore& score, const TaskScore::Sheet& sheet) {
  page.write(margin, 62, "Palpation: find the lumps", title_px);
  std::string scene = head.scene;
  if (head.lump_draw) scene += format(", seed %u, layout %d", head.lump_draw->seed, head.lump_draw->layout);
  page.write(page_width - margin, 76, scene, text_px, paper::faint, 1);
  page.write(margin, 128, "Trainee", small_px, paper::faint);
  if (head.trainee.empty())
    page.write(margin + 80, 128, "______________________________", small_px, paper::faint);
  else
    page.write(margin + 80, 125, head.trainee);
  page.write(page_width - margin, 128, head.date, small_px, paper::ink, 1);
  page.rule(170);
  const int all = static_cast<int>(score.lumps().size());
  page.write(margin, 186,
             format("%d of %s found, %s", sheet.hits, plural(all, "lump", "lumps").c_str(),
                    sheet.false_alarms == 0 ? "no false alarm"
                                            : plural(sheet.false_alarms, "false alarm", "false alarms").c_str()),
             32);
}

void writeNumbers(Page& page, const SheetHead& head, const TaskScore::Sheet& sheet) {
  float y = 240;
  const auto rows = [&](const char* a, const std::string& value_a, bool bad_a, const char* b,
                        const std::string& value_b, bool bad_b) {
    page.row(0, y, a, value_a, bad_a);
    page.row(1, y, b, value_b, bad_b);
    y += line;
  };
  rows("Found", std::to_string(sheet.hits), false, "Mean force", format("%.2f N", sheet.mean_force_N), false);
  rows("Missed", std::to_string(sheet.misses), sheet.misses > 0, "Peak force", format("%.2f N", sheet.peak_force_N),
       sheet.peak_force_N > TaskScore::force_limit);
  rows("False alarms", std::to_string(sheet.false_alarms), sheet.false_alarms > 0,
       format("Above %.0f N", TaskScore::force_limit).c_str(), format("%.1f s", sheet.seconds_above_limit),
       sheet.seconds_above_limit > 0);
  rows("Hardness told right", sheet.hits > 0 ? format("%d of %d", sheet.hardness_right, sheet.hits) : "-",
       sheet.hardness_right < sheet.hits,
       format("Skin pressed with %.0f kPa or more", 1e-3 * TaskScore::threshold_pressure).c_str(),
       format("%.0f %%", 100 * sheet.covered_share), false);
  rows("Mean error of those found", sheet.mean_error_mm ? format("%.1f mm", *sheet.mean_error_mm) : "-", false,
       "Way of the probe on the skin", format("%.2f m", sheet.path_m), false);
  rows("Time", format("%.0f s", sheet.seconds), false, "Scene's hash", head.scene_hash, false);
}

/// A line for each lump: how large, how deep, whether found; below, under which conditions.
void writeLumps(Page& page, const SheetHead& head, const TaskScore& score, const TaskScore::Sheet& sheet) {
  float y = 484;
  page.rule(y - 12);
  for (std::size_t k = 0; k < score.lumps().size() && k < most_lumps; ++k) {
    const Lump& lump = score.lumps()[k];
    std::string outcome = !score.wasPressed(k)         ? "missed, not pressed there"
                          : score.wasPressedLightly(k) ? "missed, pressed too lightly to reach it"
                                                       : "missed";
    bool found = false;
    for (std::size_t m = 0; m < score.marks().size(); ++m) {
      if (sheet.lump_of_mark[m] != static_cast<int>(k)) continue;
      found = true;
      outcome = format("found, %.1f mm off, ", 1e3 * (score.marks()[m].place - lump.foot.point).norm());
      const int said = score.marks()[m].hardness, is = hardnessOf(lump);
      outcome += said == is ? format("%s as told", hardnessName(is))
                            : format("%s, told %s", hardnessName(is), hardnessName(said));
    }
    page.write(margin, y,
               format("Lump %d: %.0f mm across, %.0f mm below the skin, %.0f times as stiff", static_cast<int>(k) + 1,
                      2e3 * lump.radius, 1e3 * lump.top, lump.stiffness),
               21, paper::faint);
    page.write(page_width - margin, y, outcome, 21, found ? paper::ink : false_colour, 1);
    y += 32;
  }
  const bool good = sheet.trust == doubtName(Doubt::None);
  std::string text = "Conditions: " + head.conditions.text() + ".";
  if (!good)
    text += format(" The forces are doubted (%s), and expected to be off by %.0f %%, if not more.", sheet.trust.c_str(),
                   100 * sheet.expected_error);
  page.writeWrapped(y + 8, text, 17, good && head.conditions.asTheSceneHasThem() ? paper::faint : false_colour);
}

/// Each way on the skin by itself: through the air none is drawn.
template <class At>
void drawPath(ImDrawList& draw, const std::vector<TaskScore::PathPoint>& path, const At& at) {
  for (std::size_t begin = 0; begin < path.size();) {
    std::vector<ImVec2> way;
    do way.push_back(at(path[begin++].tip));
    while (begin < path.size() && !path[begin].begins);
    if (way.size() == 1) {  // pressed at one place
      draw.AddCircleFilled(way[0], 3.5F, IM_COL32(255, 255, 255, 90));
      draw.AddCircleFilled(way[0], 2, IM_COL32(30, 34, 40, 150));
      continue;
    }
    strokeLine(draw, way, IM_COL32(255, 255, 255, 90), 3.5F);
    strokeLine(draw, way, IM_COL32(30, 34, 40, 130), 1.5F);
  }
}

/// Lumps, marks and the probe's path over the organ.
void drawPlaces(Page& page, const Camera& camera, const TaskScore& score, const TaskScore::Sheet& sheet) {
  ImDrawList& draw = page.list();
  const float top = page_height - map_height;
  const auto at = [&](const Vec3& x) {
    const Vec3 p = camera.project(x, page_width, map_height);
    return ImVec2(static_cast<float>(p.x()), top + static_cast<float>(p.y()));
  };
  drawPath(draw, score.path(), at);
  for (std::size_t k = 0; k < score.lumps().size(); ++k) {
    const Lump& lump = score.lumps()[k];
    const ImVec2 c = at(lump.foot.point);
    const auto r = static_cast<float>(lump.radius / camera.pixelSize(lump.foot.point, map_height));
    draw.AddCircle(c, r, paper::white, 64, 7);
    draw.AddCircle(c, r, paper::ink, 64, 3.5F);
    const std::string number = std::to_string(k + 1);
    const ImVec2 badge{c.x + 0.75F * r + 12, c.y - 0.75F * r - 12};
    draw.AddCircleFilled(badge, 16, paper::ink);
    page.write(badge.x, badge.y - 12, number, 22, paper::white, 0.5F);
  }
  for (std::size_t m = 0; m < score.marks().size(); ++m) {
    const ImVec2 c = at(score.marks()[m].place);
    const bool hit = sheet.lump_of_mark[m] >= 0;
    for (const auto& [colour, thickness, reach] :
         {std::tuple{paper::white, 10.0F, 17.0F}, {hit ? hit_colour : false_colour, 5.5F, 15.0F}}) {
      draw.AddLine({c.x - reach, c.y - reach}, {c.x + reach, c.y + reach}, colour, thickness);
      draw.AddLine({c.x - reach, c.y + reach}, {c.x + reach, c.y - reach}, colour, thickness);
    }
  }
}

/// What the signs on the map mean, and the colours' bar.
void writeKey(Page& page, const ColourScale& scale) {
  ImDrawList& draw = page.list();
  const float y = page_height - 62;
  float x = margin;
  const auto cross = [&](ImU32 colour) {
    draw.AddLine({x, y - 9}, {x + 18, y + 9}, colour, 5);
    draw.AddLine({x, y + 9}, {x + 18, y - 9}, colour, 5);
  };
  const auto name = [&](const char* text) {
    page.write(x + 28, y - 11, text, small_px, paper::faint);
    x += 28 + page.width(text, small_px) + 30;
  };
  draw.AddCircle({x + 9, y}, 10, paper::ink, 32, 3);
  name("lump");
  cross(hit_colour);
  name("found");
  cross(false_colour);
  name("false alarm");
  draw.AddLine({x, y}, {x + 18, y}, paper::ink, 2);
  name("the probe's path");

  const float left = page_width - margin - 330, right = page_width - margin, bar_top = y - 12, bar_bottom = y + 2;
  constexpr int bands = 96;
  const auto packed = [](const Vec3f& c) { return ImGui::ColorConvertFloat4ToU32({c.x(), c.y(), c.z(), 1}); };
  for (int k = 0; k < bands; ++k) {
    const float a = left + (right - left) * static_cast<float>(k) / bands;
    const float b = left + (right - left) * static_cast<float>(k + 1) / bands;
    draw.AddRectFilled({a, bar_top}, {b, bar_bottom}, packed(colourOf(scale.map, (k + 0.5) / bands)));
  }
  const ColourUnit unit = unitOf(scale.map, scale.max);
  const double high = scale.max * unit.per_si;
  const std::vector<double> ticks = roundTicks(0, high, 5);
  for (const double tick : ticks) {
    const float at = left + (right - left) * static_cast<float>(tick / high);
    draw.AddLine({at, bar_bottom}, {at, bar_bottom + 5}, paper::ink, 1.5F);
    page.write(at, bar_bottom + 7, tickLabel(tick, ticks.size() > 1 ? ticks[1] - ticks[0] : high), 17, paper::faint,
               0.5F);
  }
  page.write(left, bar_top - 27, std::string("Peak pressure, ") + unit.name, small_px, paper::faint);
}

}  // namespace

Picture scorePage(const Theme& theme, const Model& model, OrganView& view, const TaskScore& score,
                  const SheetHead& head) {
  const TaskScore::Sheet sheet = score.sheet();
  Snapshot rest;
  rest.u.assign(model.X.size(), Float4{});
  View look;
  look.camera = fromTheTool(model, view);
  look.colour_map = ColourMap::Pressure;
  look.skin_values = &score.pressureMap();
  look.show_room = look.show_tool = look.show_forces = look.show_fixed = false;

  const Framebuffer paper_sheet(page_width, page_height);
  paper_sheet.bind();
  glClearColor(1, 1, 1, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  const ColourScale scale = view.draw(rest, look, page_width, map_height);  // the lower part of the page
  paper_sheet.bind();
  Page page(theme);
  writeHead(page, head, score, sheet);
  writeNumbers(page, head, sheet);
  writeLumps(page, head, score, sheet);
  drawPlaces(page, look.camera, score, sheet);
  writeKey(page, scale);
  page.render();
  Picture picture = paper_sheet.read();
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  return picture;
}

}  // namespace palpate::app
