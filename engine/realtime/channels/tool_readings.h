#pragma once

#include <bit>
#include <cstdint>

#include "contact/tool_set.h"
#include "realtime/channels/latest_words.h"

namespace palpate {

/// What a tick says of a tool. Plain numbers, so that they go between threads as words.
struct ToolReading {
  std::array<double, 7> pose{0, 0, 0, 0, 0, 0, 1};  // m, and the quaternion x, y, z, w
  double opening = 0;                               // m, of jaws
  std::array<double, 3> force{};                    // N, on the tool
  std::array<double, 3> torque{};                   // N m, about its tip
  double pinch = 0;                                 // N, of jaws
  std::int64_t contact_count = 0;                   // points of the skin that carry force
  double expected_error = 0, error_force = 0;       // ToolLoad's
};

/// All tools of a scene.
struct ToolReadings {
  std::int64_t tick = 0;   // of the run; 0: none computed yet
  std::int64_t count = 0;  // of tools
  std::array<ToolReading, max_tools> tool;

  ToolPosture posture(int k) const {
    const ToolReading& t = tool[static_cast<std::size_t>(k)];
    ToolPosture posture;
    posture.pose.position = {t.pose[0], t.pose[1], t.pose[2]};
    posture.pose.orientation.coeffs() << t.pose[3], t.pose[4], t.pose[5], t.pose[6];
    posture.opening = t.opening;
    return posture;
  }
  void set(int k, const ToolPosture& posture, const ToolLoad& load);
};

/// The newest readings, from the loop to any number of readers.
class ToolsOutput {
 public:
  ToolsOutput() { publish({}); }
  void publish(const ToolReadings& readings) { words_.publish(std::bit_cast<Words::Words>(readings)); }
  ToolReadings latest() const { return std::bit_cast<ToolReadings>(words_.latest()); }

 private:
  using Words = LatestWords<sizeof(ToolReadings) / sizeof(std::uint64_t)>;
  Words words_;
};

}  // namespace palpate
