#pragma once

#include <string>
#include <vector>

#include "app/trainer/lumps.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// Where a trainee says that a lump is.
struct LumpMark {
  Vec3 place = Vec3::Zero();  // m, on the skin at rest
  int hardness = 2;           // 1 a little, 2 clearly, 3 much harder than around
  double time_s = 0;          // of the run
};

/// Keeps what a task's score is made of, sample by sample, and makes the score sheet. It depends on samples and marks
/// alone, so a replay scores the same, bit for bit. Belongs to the main thread.
class TaskScore {
 public:
  static constexpr double force_limit = 4;               // N: more hurts
  static constexpr double threshold_pressure = 1000;     // Pa: less feels nothing
  static constexpr double path_step = 0.002;             // m, between two points of the path
  static constexpr std::size_t most_path_points = 8192;  // the path of a longer way is coarser
  static constexpr double mark_tolerance = 0.008;        // m beyond the lump's radius that a mark still counts

  TaskScore(const Model& model, std::vector<Lump> lumps);

  void add(const ForceSample& sample);
  void mark(const Vec3& place, int hardness, double time_s);
  void unmark() {
    if (!marks_.empty()) marks_.pop_back();
  }
  const std::vector<LumpMark>& marks() const { return marks_; }
  const std::vector<Lump>& lumps() const { return lumps_; }
  double seconds() const { return seconds_; }

  struct Sheet {
    int hits = 0, misses = 0, false_alarms = 0;
    double mean_error_mm = 0;  // of the hits
    double seconds = 0, mean_force_N = 0, peak_force_N = 0, seconds_above_limit = 0;
    double covered_share = 0;       // of the skin that the tool gets to
    double path_m = 0;              // of the tip while it touches
    int missed_too_light = 0;       // lumps that were missed where nobody pressed to their depth
    std::vector<int> lump_of_mark;  // (mark_count) -1: none
  };
  Sheet sheet() const;

  /// The sheet with lumps, marks, path and the map of peak pressure.
  std::string json(const std::string& scene) const;

  /// Peak pressure at the skin's vertices, Pa  (skin vertex_count)
  const std::vector<float>& pressureMap() const { return pressure_; }
  /// Where the tip went while it touched: each 2 mm, or where that makes too many points, 4, 8, ...
  const std::vector<Vec3>& path() const { return path_; }
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
  std::vector<double> deepest_;    // (lump_count) m pressed above it
  std::vector<Vec3> path_;         // m
  double kept_step_ = path_step;   // m, between its points
  Vec3 walked_to_ = Vec3::Zero();  // m, where length_ ends
  std::int64_t samples_ = 0, touching_ = 0, above_limit_ = 0;
  double force_sum_ = 0, peak_ = 0, seconds_ = 0, length_ = 0, begin_s_ = -1;
};

}  // namespace palpate::app
