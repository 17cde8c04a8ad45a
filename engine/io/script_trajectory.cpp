#include "io/script_trajectory.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

constexpr double corner_seconds = 0.02;  // half the time that a change of speed takes

}  // namespace

ScriptTrajectory::ScriptTrajectory(ToolScript script, const Pose& start, double first_contact_travel, double rate_hz,
                                   double opening)
    : script_(std::move(script)),
      start_(start),
      first_contact_travel_(first_contact_travel),
      rate_hz_(rate_hz),
      reach_(std::llround(corner_seconds * rate_hz)),
      last_(std::max<std::int64_t>(1, std::llround(std::ceil(script_.duration() * rate_hz))) - 1),
      start_opening_(opening),
      opening_(opening),
      held_opening_(opening < 0 ? 0 : static_cast<std::size_t>(2 * reach_ + 1)),
      position_(static_cast<std::size_t>(2 * reach_ + 1)) {}

void ScriptTrajectory::hold(std::int64_t k) {
  for (; held_ <= k; ++held_) {
    const double time = static_cast<double>(std::min(held_, last_) + 1) / rate_hz_;
    held(held_) = poseAt(script_, start_, first_contact_travel_, time).position;
    if (!held_opening_.empty())
      held_opening_[static_cast<std::size_t>(held_) % held_opening_.size()] = openingAt(script_, start_opening_, time);
  }
}

Pose ScriptTrajectory::next() {
  const std::int64_t k = std::min(tick_, last_ + reach_);
  const std::int64_t r = std::min(reach_, k);
  hold(k + r);
  Vec3 sum = Vec3::Zero();
  for (std::int64_t j = k - r; j <= k + r; ++j) sum += held(j);
  if (!held_opening_.empty()) {
    double openings = 0;
    for (std::int64_t j = k - r; j <= k + r; ++j)
      openings += held_opening_[static_cast<std::size_t>(j) % held_opening_.size()];
    opening_ = openings / static_cast<double>(2 * r + 1);
  }
  ++tick_;
  Pose pose = start_;
  pose.position = sum / static_cast<double>(2 * r + 1);
  return pose;
}

void ScriptTrajectory::restart() {
  tick_ = held_ = 0;
  opening_ = start_opening_;
}

}  // namespace palpate
