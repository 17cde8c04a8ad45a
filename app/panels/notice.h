#pragma once

#include <optional>
#include <string>

#include "realtime/channels/log_event.h"

namespace palpate::app {

/// What the program has to say when the tissue can't go on as the hand wants: one sentence for whoever holds the probe,
/// and the details for whoever made the scene.
struct Notice {
  std::string sentence;
  std::string details;  // numbers, places, what to change in the scene
  double time_s = 0;    // of the run
  bool frozen = false;  // stays until undone or reset
};

/// The notice for an event of the loop; empty where nobody need be disturbed.
std::optional<Notice> noticeOf(const LogEvent& event);

}  // namespace palpate::app
