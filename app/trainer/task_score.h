#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/trainer/lumps.h"
#include "realtime/channels/snapshot.h"
#include "scene/scene.h"
#include "step/trust.h"

namespace palpate::app {

/// Where a trainee says that a lump is.
struct LumpMark {
  Vec3 place = Vec3::Zero();  // m, on the skin at rest
  int hardness = 2;           // 1 a little, 2 clearly, 3 much harder than around
  double time_s = 0;          // of the run
};

/// How hard a lump is, in the words of a mark: 1 a little, 2 clearly, 3 much harder than the tissue around. The bounds,
/// 3 and 10 times as stiff, lie between what Samani et al. (2007) measured of breast tissue against what is normal
/// there: fibroadenomas 2, carcinomas of low grade 3 to 5, of high grade 13 times.
int hardnessOf(const Lump& lump);
const char* hardnessName(int hardness);

/// Under which conditions a search is made.
struct Conditions {
  std::string moved_by = "hand";     // that; a script, recording, device or trainee by rule
  std::string probe;                 // "sphere, radius 6 mm"
  bool probe_of_scene = true;        // else one was chosen in its place
  double friction = 0;               // at the search's begin
  double rate_hz = 0;                // ticks a second
  bool rate_of_scene = true;         // likewise
  std::vector<std::string> changes;  // of friction and materials meanwhile: only a recording brings any
  int undos = 0, resets = 0;
  int answers_seen = 0;  // times that this program showed the answers of this scene before

  /// Nothing was made easier, harder or known before.
  bool asTheSceneHasThem() const { return probe_of_scene && rate_of_scene && changes.empty() && answers_seen == 0; }
  /// "moved by hand; sphere, radius 6 mm; ..."
  std::string text() const;
};

/// What the JSON of a score says that it is ("kind").
inline constexpr const char* score_kind = "palpate score";

/// What a sheet says beside the score: who searched, when, where, under which conditions.
struct SheetHead {
  std::string scene{}, trainee{}, date{};  // "2025-03-01 14:05"; the trainee may be empty
  std::string scene_hash{};                // of the scene's file, as in manifest.json
  std::string model_hash{};                // of what was made of it
  std::optional<LumpDraw> lump_draw{};
  Conditions conditions{};
};

/// Keeps what a task's score is made of, sample by sample, and makes the score sheet. It depends on samples and marks
/// alone, so a replay scores the same, bit for bit. Belongs to the main thread.
class TaskScore {
 public:
  static constexpr double force_limit = 4;               // N: more hurts
  static constexpr double threshold_pressure = 1000;     // Pa: less feels nothing
  static constexpr double path_step = 0.002;             // m, between two points of the path; a lift-off is longer
  static constexpr std::size_t most_path_points = 8192;  // the path of a longer way is coarser
  static constexpr double mark_tolerance = 0.008;        // m beyond the lump's radius that a mark still counts

  TaskScore(const Model& model, std::vector<Lump> lumps);

  void add(const ForceSample& sample);
  void mark(const Vec3& place, int hardness, double time_s);
  void unmark() {
    if (!marks_.empty()) marks_.pop_back();
  }
  /// The tool was put elsewhere: no way leads from where it was.
  void breakPath() { path_broken_ = true; }
  const std::vector<LumpMark>& marks() const { return marks_; }
  const std::vector<Lump>& lumps() const { return lumps_; }
  double seconds() const { return seconds_; }
  /// Whether something was felt or marked.
  bool begun() const { return touching_ > 0 || !marks_.empty(); }

  struct Sheet {
    int hits = 0, misses = 0, false_alarms = 0;
    std::optional<double> mean_error_mm;  // of the hits; null: there are none
    int hardness_right = 0;               // of the hits
    double seconds = 0, mean_force_N = 0, peak_force_N = 0, seconds_above_limit = 0;
    std::string trust;              // of the forces: "good", or why they are doubted
    double expected_error = 0;      // of the largest of them, as a share
    double covered_share = 0;       // of the skin that the tool gets to
    double path_m = 0;              // of the tip while it touches
    int missed_too_light = 0;       // lumps that were missed where nobody pressed to their depth
    std::vector<int> lump_of_mark;  // (mark_count) -1: none
  };
  Sheet sheet() const;

  /// The sheet with lumps, marks and path.
  /// @param pressure_file  where pressureCsv() is kept beside it
  std::string json(const SheetHead& head, const std::string& pressure_file) const;
  /// The map of peak pressure: a row for each of the skin's vertices, at rest.
  std::string pressureCsv() const;

  /// Peak pressure at the skin's vertices, Pa  (skin vertex_count)
  const std::vector<float>& pressureMap() const { return pressure_; }
  /// Where the tip went while it touched: each 2 mm, or where that makes too many points, 4, 8, ...
  struct PathPoint {
    Vec3 tip;             // m
    bool begins = false;  // the probe came down here: no way leads from the point before
  };
  const std::vector<PathPoint>& path() const { return path_; }
  /// Whether the probe pressed over this lump at all.
  bool wasPressed(std::size_t lump) const { return deepest_[lump] > 0; }
  /// Whether nobody pressed deep enough over this lump to feel it.
  bool wasPressedLightly(std::size_t lump) const;

 private:
  void followPath(const Vec3& tip);

  const Model& model_;
  std::vector<Lump> lumps_;
  SkinSurface skin_;
  std::vector<LumpMark> marks_;
  std::vector<float> pressure_;
  std::vector<double> deepest_;  // (lump_count) m pressed above it
  std::vector<PathPoint> path_;
  double kept_step_ = path_step;    // m, between its points
  Vec3 walked_to_ = Vec3::Zero();   // m, where length_ ends
  Vec3 touched_at_ = Vec3::Zero();  // m, the tip when it touched last
  bool lifted_ = true;              // it has not touched since
  bool path_broken_ = true;
  std::int64_t samples_ = 0, touching_ = 0, above_limit_ = 0;
  RunTrust trust_;
  double force_sum_ = 0, peak_ = 0, seconds_ = 0, length_ = 0, begin_s_ = -1;
};

}  // namespace palpate::app
