#include "realtime/loop/tool_track.h"

#include <cmath>
#include <limits>
#include <utility>

namespace palpate {
namespace {

// The viewer asks for tool poses at its own, slower and uneven rate. The tool goes
// after the newest with this time constant, so that it moves evenly between them;
// longer is smoother, and lags more.
constexpr double kFollowSeconds = 0.02;
constexpr double kArrivedDistance = 1e-7;  // m
constexpr double kArrivedAngle = 1e-5;     // rad

/// `from`, moved towards `to` by the share `gain` of the way.
Pose follow(const Pose& from, const Pose& to, double gain) {
  if ((to.position - from.position).norm() < kArrivedDistance &&
      from.orientation.angularDistance(to.orientation) < kArrivedAngle) {
    return to;
  }
  Pose pose;
  pose.position = from.position + gain * (to.position - from.position);
  pose.orientation = from.orientation.slerp(gain, to.orientation).normalized();
  return pose;
}

constexpr std::int64_t kEndless = std::numeric_limits<std::int64_t>::max();

std::int64_t lengthOf(const std::vector<TimedRequest>& track, std::int64_t ticks, const ToolMotion* motion) {
  if (ticks == 0 && motion != nullptr) return kEndless;
  if (motion == nullptr && track.empty()) return 0;
  return ticks > 0 ? ticks : track.back().tick + 1;
}

}  // namespace

ToolTrack::ToolTrack(std::vector<TimedRequest> track, std::int64_t ticks, ToolMotion* motion, const Pose& start,
                     double rate_hz)
    : track_(std::move(track)),
      end_(lengthOf(track_, ticks, motion)),
      motion_(motion),
      start_(start),
      follow_gain_(-std::expm1(-1 / (kFollowSeconds * rate_hz))),
      goal_(start, rate_hz) {
  for (std::size_t k = 0; k < track_.size(); ++k)
    if (track_[k].request.kind == Request::Kind::GoToPlace) places_.push_back(k);
}

bool ToolTrack::drives(std::int64_t tick) const { return tick - begin_ < end_; }

const Request* ToolTrack::takeDue(std::int64_t tick) {
  if (next_ >= track_.size() || track_[next_].tick > tick - begin_) return nullptr;
  return &track_[next_++].request;
}

const PlaceIndex& ToolTrack::nextPlace() {
  while (next_place_ < places_.size() && places_[next_place_] < next_) ++next_place_;
  return next_place_ < places_.size() ? track_[places_[next_place_]].request.place : no_place;
}

const Request* ToolTrack::takeSetting(std::int64_t tick, bool frozen) {
  return drives(tick) && motion_ != nullptr && !frozen ? motion_->nextSetting() : nullptr;
}

Pose ToolTrack::next(std::int64_t tick, const Pose& present, const State& state, const StepReport& last, bool frozen) {
  if (!drives(tick)) {
    goal_.advance();
    return follow(present, goal_.pose(), follow_gain_);
  }
  if (motion_ == nullptr || frozen) return present;
  goal_.jumpTo(motion_->next(state, last));
  return goal_.pose();
}

double ToolTrack::opening(std::int64_t tick, bool frozen) const {
  return drives(tick) && motion_ != nullptr && !frozen ? motion_->opening() : -1;
}

void ToolTrack::reset() {
  goal_.jumpTo(start_);
  if (motion_ != nullptr) motion_->restart();
}

bool ToolTrack::startOver(std::int64_t tick) {
  if (track_.empty() && (motion_ == nullptr || end_ == kEndless)) return false;
  begin_ = tick;
  next_ = next_place_ = 0;
  return true;
}

}  // namespace palpate
