#pragma once

#include <deque>
#include <string>
#include <vector>

#include "app/panels/plot.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// One press, from the first touch until the tool has left the skin: force (N) over depth (mm), in the order of time.
struct Press {
  int number = 0;      // from 1, in the session
  double begin_s = 0;  // of the run
  double peak_N = 0, peak_mm = 0;
  double loaded_mJ = 0, lost_mJ = 0;  // work done while it went in; of that, what did not come back
  std::vector<PlotPoint> curve;
};

/// The presses of a session, to be laid over one another. Belongs to the main thread.
class PressCurves {
 public:
  static constexpr std::size_t most_kept = 50;      // the oldest go
  static constexpr std::size_t most_points = 4000;  // of a press
  static constexpr double least_N = 0.005;          // a press that never reaches it is a brush

  void add(const ForceSample& sample);
  void clear();

  /// The finished presses, oldest first; the present one is the last where one is under way.
  const std::deque<Press>& all() const { return presses_; }
  bool underWay() const { return under_way_; }

  /// As CSV with the columns press, time_begin_s, depth_mm, force_N.
  std::string csv() const;

 private:
  std::deque<Press> presses_;
  PlotPoint last_;  // of the present press
  bool under_way_ = false;
  int air_ = 0;  // samples in a row without force
  int number_ = 0;
};

}  // namespace palpate::app
