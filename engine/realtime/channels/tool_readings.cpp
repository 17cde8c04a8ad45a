#include "realtime/channels/tool_readings.h"

#include <algorithm>

namespace palpate {

void ToolReadings::set(int k, const ToolPosture& posture, const ToolLoad& load) {
  ToolReading& t = tool[static_cast<std::size_t>(k)];
  std::copy_n(posture.pose.position.data(), 3, t.pose.begin());
  std::copy_n(posture.pose.orientation.coeffs().data(), 4, t.pose.begin() + 3);
  t.opening = posture.opening;
  std::copy_n(load.force.data(), 3, t.force.begin());
  std::copy_n(load.torque.data(), 3, t.torque.begin());
  t.pinch = load.pinch;
  t.contact_count = load.contact_count;
  t.expected_error = load.expected_error;
  t.error_force = load.error_force;
}

}  // namespace palpate
