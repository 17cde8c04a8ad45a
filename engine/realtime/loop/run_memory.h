#pragma once

#include <cstdint>

#include "base/types.h"
#include "model/report.h"
#include "realtime/channels/snapshot.h"
#include "realtime/channels/tool_readings.h"
#include "realtime/loop/contact_trend.h"
#include "realtime/loop/fold_watch.h"
#include "realtime/loop/force_filter.h"
#include "realtime/loop/further_hands.h"
#include "realtime/loop/tool_proxy.h"

namespace palpate {

/// What a run's coming ticks depend on beside the physics' State, and what is told of the present one. Plain data.
struct RunMemory {
  std::int64_t tick = 0;  // of the run
  bool frozen = false;
  Pose hand;
  std::uint64_t pose_sequence = 0;
  std::array<ToolProxy::Memory, max_tools> proxies;
  ToolPostures hands;  // of the tools beside the first; of the first its opening
  FurtherHands::Memory further;
  ToolReadings readings;
  FoldWatch::Memory folds;
  StepReport report;
  ForceSample force;
  ForceFilter filter{0, 0, 1};
  ContactTrend trend;
};

}  // namespace palpate
