#include "app/trainer/task_score.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "base/number_text.h"

namespace palpate::app {

namespace {

constexpr double reached_cosine = 0.3;  // of the skin to the tool's way, where the tool gets to
constexpr double light_share = 0.5;     // of a lump's depth that must be pressed to feel it

using Json = nlohmann::ordered_json;

Json millimetres(const Vec3& v) { return {1e3 * v.x(), 1e3 * v.y(), 1e3 * v.z()}; }

const char* times(int count) { return count == 1 ? "time" : "times"; }

}  // namespace

int hardnessOf(const Lump& lump) {
  constexpr double clearly = 3, much = 10;  // times as stiff
  return lump.stiffness < clearly ? 1 : lump.stiffness < much ? 2 : 3;
}

const char* hardnessName(int hardness) { return hardness <= 1 ? "firm" : hardness == 2 ? "hard" : "very hard"; }

std::string Conditions::text() const {
  std::string text = "moved by " + moved_by + "; " + probe;
  if (!probe_of_scene) text += ", not the scene's";
  text += format("; friction %.3g; %.0f ticks a second", friction, rate_hz);
  if (!rate_of_scene) text += ", not the scene's";
  text += "; what shows the inside was shut until the answers were in";
  if (changes.empty()) text += "; friction and materials as they were";
  for (const std::string& change : changes) text += "; " + change;
  text += format("; undone %d %s, reset %d %s", undos, times(undos), resets, times(resets));
  if (answers_seen > 0)
    text += format("; the answers had been seen %d %s before, since the program was started", answers_seen,
                   times(answers_seen));
  return text;
}

TaskScore::TaskScore(const Model& model, std::vector<Lump> lumps)
    : model_(model),
      lumps_(std::move(lumps)),
      skin_(model.skin.surface),
      pressure_(model.skin.surface.vertices.size(), 0.0F),
      deepest_(lumps_.size(), 0.0) {
  path_.reserve(most_path_points);
}

void TaskScore::add(const ForceSample& sample) {
  if (begin_s_ < 0) begin_s_ = sample.time_s;
  seconds_ = sample.time_s - begin_s_;
  ++samples_;
  trust_.add(sample.doubt, sample.expected_error, sample.error_force, sample.time_s, sample.error_by);
  const double force = sample.force_raw.norm();
  if (!(force > 0) || !std::isfinite(force)) {
    lifted_ = true;
    return;
  }
  ++touching_;
  force_sum_ += force;
  peak_ = std::max(peak_, force);
  if (force > force_limit) ++above_limit_;

  const Vec3& tip = sample.tool_pose.position;
  const double depth = std::max(0.0, sample.depth_m);
  const Vec3 foot = tip + depth * (sample.tool_pose.orientation * Vec3::UnitZ());  // about where the skin was
  for (std::size_t k = 0; k < lumps_.size(); ++k)
    if ((lumps_[k].foot.point - foot).norm() < lumps_[k].radius + mark_tolerance)
      deepest_[k] = std::max(deepest_[k], depth);
  // The patch of a ball of radius R that is d deep has about the radius sqrt(R d).
  const double R = model_.scene.tools[0].shape.radius;
  const double patch = std::min(R, std::sqrt(R * std::max(depth, 1e-4)));
  const auto pressure = static_cast<float>(force / (std::numbers::pi * patch * patch));
  for (std::size_t v = 0; v < pressure_.size(); ++v)
    if ((model_.skin.surface.vertices[v] - foot).squaredNorm() < patch * patch)
      pressure_[v] = std::max(pressure_[v], pressure);
  followPath(tip);
}

/// A skip that is shorter than a step is none: the probe may tremble on the skin.
void TaskScore::followPath(const Vec3& tip) {
  if (std::exchange(lifted_, false) && (tip - touched_at_).norm() > path_step) path_broken_ = true;
  touched_at_ = tip;
  const bool begins = std::exchange(path_broken_, false);
  if (begins) walked_to_ = tip;
  const double way = (tip - walked_to_).norm();
  if (way > path_step) {
    length_ += way;
    walked_to_ = tip;
  }
  if (!begins && (tip - path_.back().tip).norm() <= kept_step_) return;
  if (path_.size() == most_path_points) {  // every second one goes
    for (std::size_t k = 0; 2 * k < path_.size(); ++k) {
      const bool came_down = path_[2 * k].begins || (k > 0 && path_[2 * k - 1].begins);
      path_[k] = {path_[2 * k].tip, came_down};
    }
    path_.resize(most_path_points / 2);
    kept_step_ *= 2;
  }
  path_.push_back({tip, begins});
}

void TaskScore::mark(const Vec3& place, int hardness, double time_s) {
  marks_.push_back({skin_.nearest(place).point, std::clamp(hardness, 1, 3), time_s});
}

bool TaskScore::wasPressedLightly(std::size_t lump) const { return deepest_[lump] < light_share * lumps_[lump].top; }

TaskScore::Sheet TaskScore::sheet() const {
  Sheet sheet;
  std::vector<bool> found(lumps_.size(), false);
  double errors = 0;
  for (const LumpMark& mark : marks_) {
    int nearest = -1;
    double least = 1e9;
    for (std::size_t k = 0; k < lumps_.size(); ++k) {
      const double error = (lumps_[k].foot.point - mark.place).norm();
      if (found[k] || error > lumps_[k].radius + mark_tolerance || error >= least) continue;
      least = error;
      nearest = static_cast<int>(k);
    }
    sheet.lump_of_mark.push_back(nearest);
    if (nearest < 0) continue;
    found[static_cast<std::size_t>(nearest)] = true;
    errors += least;
    ++sheet.hits;
    if (mark.hardness == hardnessOf(lumps_[static_cast<std::size_t>(nearest)])) ++sheet.hardness_right;
  }
  sheet.misses = static_cast<int>(lumps_.size()) - sheet.hits;
  sheet.false_alarms = static_cast<int>(marks_.size()) - sheet.hits;
  if (sheet.hits > 0) sheet.mean_error_mm = 1e3 * errors / sheet.hits;
  for (std::size_t k = 0; k < lumps_.size(); ++k)
    if (!found[k] && wasPressedLightly(k)) ++sheet.missed_too_light;
  sheet.seconds = seconds_;
  sheet.mean_force_N = touching_ > 0 ? force_sum_ / static_cast<double>(touching_) : 0;
  sheet.peak_force_N = peak_;
  sheet.trust = doubtName(trust_.doubt());
  sheet.expected_error = trust_.expectedError();
  sheet.seconds_above_limit = static_cast<double>(above_limit_) / model_.scene.dynamics.rate_hz;
  sheet.path_m = length_;
  double covered = 0, reached = 0;
  for (std::size_t v = 0; v < pressure_.size(); ++v) {
    const double area = v < model_.skin.area.size() ? model_.skin.area[v] : 1;
    if (skin_.nearest(model_.skin.surface.vertices[v]).normal.dot(-model_.scene.tools[0].direction) < reached_cosine)
      continue;
    reached += area;
    if (static_cast<double>(pressure_[v]) >= threshold_pressure) covered += area;
  }
  sheet.covered_share = reached > 0 ? covered / reached : 0;
  return sheet;
}

std::string TaskScore::json(const SheetHead& head, const std::string& pressure_file) const {
  const Sheet s = sheet();
  const Conditions& c = head.conditions;
  Json json = {{"kind", score_kind},
               {"trainee", head.trainee},
               {"date", head.date},
               {"scene", head.scene},
               {"scene_hash", head.scene_hash},
               {"model_hash", head.model_hash},
               {"level", nullptr},
               {"seed", nullptr},
               {"layout", nullptr},
               {"hits", s.hits},
               {"misses", s.misses},
               {"false_alarms", s.false_alarms},
               {"hardness_right", s.hardness_right},
               {"mean_error_mm", s.mean_error_mm ? Json(*s.mean_error_mm) : Json(nullptr)},
               {"seconds", s.seconds},
               {"mean_force_N", s.mean_force_N},
               {"peak_force_N", s.peak_force_N},
               {"trust", s.trust},
               {"expected_error", s.expected_error},
               {"force_limit_N", force_limit},
               {"seconds_above_limit", s.seconds_above_limit},
               {"threshold_pressure_Pa", threshold_pressure},
               {"covered_share", s.covered_share},
               {"path_m", s.path_m},
               {"missed_too_light", s.missed_too_light}};
  if (head.lump_draw) {
    json["level"] = head.lump_draw->level;
    json["seed"] = head.lump_draw->seed;
    json["layout"] = head.lump_draw->layout;
  }
  json["conditions"] = {{"moved_by", c.moved_by},
                        {"probe", c.probe},
                        {"probe_of_scene", c.probe_of_scene},
                        {"friction", c.friction},
                        {"rate_hz", c.rate_hz},
                        {"rate_of_scene", c.rate_of_scene},
                        {"inside_shown", false},
                        {"changes", c.changes},
                        {"undos", c.undos},
                        {"resets", c.resets},
                        {"answers_seen", c.answers_seen}};
  json["marks"] = Json::array();
  for (std::size_t k = 0; k < marks_.size(); ++k)
    json["marks"].push_back({{"place_mm", millimetres(marks_[k].place)},
                             {"hardness", marks_[k].hardness},
                             {"time_s", marks_[k].time_s},
                             {"lump", s.lump_of_mark[k] < 0 ? Json(nullptr) : Json(s.lump_of_mark[k])}});
  json["lumps"] = Json::array();
  for (std::size_t k = 0; k < lumps_.size(); ++k)
    json["lumps"].push_back({{"centre_mm", millimetres(lumps_[k].centre)},
                             {"radius_mm", 1e3 * lumps_[k].radius},
                             {"top_mm", 1e3 * lumps_[k].top},
                             {"stiffness", lumps_[k].stiffness},
                             {"hardness", hardnessOf(lumps_[k])},
                             {"pressed_mm", 1e3 * deepest_[k]}});
  json["path_mm"] = Json::array();  // of each way on the skin its points
  for (const PathPoint& point : path_) {
    if (point.begins) json["path_mm"].push_back(Json::array());
    json["path_mm"].back().push_back(millimetres(point.tip));
  }
  json["pressure_file"] = pressure_file;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string TaskScore::pressureCsv() const {
  std::string csv = "x_mm,y_mm,z_mm,peak_pressure_Pa\n";
  for (std::size_t v = 0; v < pressure_.size(); ++v) {
    const Vec3 X = 1e3 * model_.skin.surface.vertices[v];
    csv += format("%.6g,%.6g,%.6g,", X.x(), X.y(), X.z()) + shortest(static_cast<double>(pressure_[v])) + "\n";
  }
  return csv;
}

}  // namespace palpate::app
