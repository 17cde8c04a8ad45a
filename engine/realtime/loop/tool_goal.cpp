#include "realtime/loop/tool_goal.h"

#include <algorithm>
#include <cmath>

namespace palpate {

void ToolGoal::jumpTo(const Pose& pose) {
  pose_ = pose;
  way_count_ = 0;
  steer_ticks_ = 0;
}

std::int64_t ToolGoal::ticksIn(double seconds) const {
  const double bounded = seconds > 0 ? std::min(seconds, longest_seconds) : 0;  // not a number: 0
  return std::max<std::int64_t>(1, std::llround(bounded * rate_hz_));
}

void ToolGoal::moveTo(const Pose& pose, double seconds) {
  ways_[0] = {pose, ticksIn(seconds)};
  way_count_ = 1;
}

void ToolGoal::thenMoveTo(const Pose& pose, double seconds) {
  way_count_ = std::min(way_count_ + 1, max_ways);
  ways_[way_count_ - 1] = {pose, ticksIn(seconds)};
}

void ToolGoal::steer(const Vec3& velocity, const Vec3& turn, double seconds) {
  velocity_ = velocity;
  turn_ = turn;
  steer_ticks_ = velocity.isZero(0) && turn.isZero(0) ? 0 : ticksIn(seconds);
}

void ToolGoal::advance() {
  if (way_count_ > 0) {
    Way& way = ways_[0];
    if (way.ticks <= 1) {
      pose_ = way.to;  // exactly
      for (std::size_t k = 1; k < way_count_; ++k) ways_[k - 1] = ways_[k];
      --way_count_;
    } else {
      const double share = 1 / static_cast<double>(way.ticks--);
      pose_.position += share * (way.to.position - pose_.position);
      pose_.orientation = pose_.orientation.slerp(share, way.to.orientation).normalized();
    }
  }
  if (steer_ticks_ <= 0) return;
  --steer_ticks_;
  pose_.position += velocity_ / rate_hz_;
  const double angle = turn_.norm() / rate_hz_;
  if (angle > 0)
    pose_.orientation = (Quat(Eigen::AngleAxisd(angle, turn_.normalized())) * pose_.orientation).normalized();
}

}  // namespace palpate
