#pragma once

#include <cstdint>
#include <vector>

#include "realtime/channels/command_queue.h"

namespace palpate::app {

/// The changes of input of a run from its start, so that it can be saved as a recording at any time. A tool in motion
/// changes with every tick: its poses are kept in an eighth of a request's room.
class KeptChanges {
 public:
  static constexpr std::size_t most_poses = 1'000'000;  // half an hour of unceasing motion at 500 Hz; 80 MB

  void add(const TimedRequest& change);
  /// More came than are kept: the run can't be repeated any more.
  bool overflowed() const { return overflowed_; }

  /// Those that take effect before tick `end`, and what was said until then, in their order.
  std::vector<TimedRequest> before(std::int64_t end) const;

 private:
  struct PoseChange {
    std::int64_t tick = 0;
    Pose pose;
    double value = 0;
  };
  struct OtherChange {
    std::size_t after = 0;  // so many poses
    TimedRequest change;
  };
  std::vector<PoseChange> poses_;
  std::vector<OtherChange> others_;
  bool overflowed_ = false;
};

}  // namespace palpate::app
