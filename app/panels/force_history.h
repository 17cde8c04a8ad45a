#pragma once

#include <span>
#include <vector>

#include "app/panels/plot.h"
#include "realtime/channels/snapshot.h"
#include "step/trust.h"

namespace palpate::app {

/// The force samples of the last seconds, ready to plot. Magnitudes, N; depth in mm.
/// Belongs to the drawing thread.
class ForceHistory {
 public:
  /// @param seconds  how far back the plots reach
  explicit ForceHistory(double seconds) : seconds_(seconds) {}

  /// Appends a sample. One that is older than the last begins a new history (after a reset).
  /// @param readings  of that tick, where the scene has several tools
  void add(const ForceSample& sample, const ToolReadings& readings = {});
  void clear();

  double seconds() const { return seconds_; }
  double lastTime() const { return last_time_; }  // s of the run; < 0: none
  /// The kept samples, oldest first; all four have the same length.
  std::span<const PlotPoint> rawOverTime() const { return kept(raw_time_); }
  std::span<const PlotPoint> filteredOverTime() const { return kept(filtered_time_); }
  std::span<const PlotPoint> rawOverDepth() const { return kept(raw_depth_); }
  std::span<const PlotPoint> filteredOverDepth() const { return kept(filtered_depth_); }

  /// Since the beginning or the last clear(): what is doubted, and of how large a share of the samples anything is.
  const RunTrust& trust() const { return trust_; }
  double doubtedShare() const {
    return samples_ > 0 ? static_cast<double>(doubted_) / static_cast<double>(samples_) : 0;
  }
  double peakRaw() const { return peak_raw_; }            // N, likewise
  double peakFiltered() const { return peak_filtered_; }  // N

 private:
  std::span<const PlotPoint> kept(const std::vector<PlotPoint>& all) const { return std::span(all).subspan(first_); }

  double seconds_;
  double last_time_ = -1;
  std::size_t first_ = 0;  // samples before it are older than seconds_
  std::vector<PlotPoint> raw_time_, filtered_time_, raw_depth_, filtered_depth_;
  double peak_raw_ = 0, peak_filtered_ = 0;
  RunTrust trust_;
  std::int64_t samples_ = 0, doubted_ = 0;
};

}  // namespace palpate::app
