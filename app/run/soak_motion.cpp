#include "app/run/soak_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate::app {
namespace {

// Mean speeds, m/s; the greatest of a leg is 1.875 times that. A careful finger to a quick hand.
constexpr double kTravelSpeed = 0.2;
constexpr double kPressSlow = 0.01, kPressFast = 0.08;
constexpr double kDragSlow = 0.005, kDragFast = 0.05;
constexpr double kLeastLeg = 0.05;                   // s: no leg is a jerk
constexpr double kLeastDepth = 0.3;                  // of the place's
constexpr double kDragShort = 0.2, kDragLong = 0.6;  // tool radii

}  // namespace

void addTick(SoakCycle& cycle, const StepReport& report) {
  cycle.flags |= report.flags;
  cycle.not_finite += (report.flags & kNotFinite) != 0 || !report.tool_force.allFinite();
  cycle.min_J = std::min(cycle.min_J, report.min_J);
  cycle.peak_force_N = std::max(cycle.peak_force_N, report.tool_force.norm());
}

SoakMotion::SoakMotion(const Body& model, std::vector<SoakPlace> places, unsigned seed, int most_nodes)
    : start_(model.tools.first().start.pose),
      tick_seconds_(1 / model.scene.dynamics.rate_hz),
      tool_radius_(model.scene.tools[0].shape.radius),
      places_(std::move(places)),
      seed_(seed),
      rest_(model, RestWatch::rest_hold_s, most_nodes),
      random_(seed) {
  for (const Vec3& X : model.skin.surface.vertices) lift_ = std::min(lift_, -start_.toLocal(X).z() - tool_radius_);
  plan();
}

double SoakMotion::uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }

/// Seconds for a distance at a speed out of the range.
double SoakMotion::oneOf(double low, double high, double distance) {
  return std::max(kLeastLeg, distance / uniform(low, high));
}

void SoakMotion::plan() {
  const SoakPlace& place = places_[random_() % places_.size()];
  const double depth = uniform(kLeastDepth, 1) * place.depth;
  const double angle = uniform(0, 2 * EIGEN_PI);
  const double length = uniform(kDragShort, kDragLong) * tool_radius_;
  const Eigen::Vector2d dragged = place.slide + length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const double in = place.touch + depth, way = place.touch - lift_;
  const double up = std::abs(lift_ - from_.advance) + (place.slide - from_.slide).norm();
  legs_ = {Leg{lift_, place.slide, std::max(kLeastLeg, up / kTravelSpeed)},
           Leg{place.touch, place.slide, std::max(kLeastLeg, way / kTravelSpeed)},
           Leg{in, place.slide, oneOf(kPressSlow, kPressFast, depth)},
           Leg{in, dragged, oneOf(kDragSlow, kDragFast, length)},
           Leg{lift_, dragged, oneOf(kPressFast, kTravelSpeed, way + depth)}};
  leg_ = 0;
  leg_time_ = 0;
  rest_.begin();
  cycle_ = {.number = cycle_.number + 1, .depth_m = depth};
}

void SoakMotion::restart() {
  random_.seed(seed_);
  from_ = {};
  cycle_ = {};
  rest_.forgetFirst();
  plan();
}

Pose SoakMotion::poseAt(const Leg& from, const Leg& to, double share) const {
  const double s = share * share * share * (10 + share * (6 * share - 15));  // at rest at both ends
  const Eigen::Vector2d slide = from.slide + s * (to.slide - from.slide);
  const double advance = from.advance + s * (to.advance - from.advance);
  Pose pose = start_;
  pose.position += start_.orientation * Vec3(slide.x(), slide.y(), -advance);
  return pose;
}

void SoakMotion::watch(const State& state, const StepReport& last) {
  addTick(cycle_, last);
  if (leg_ < legs_.size() || !rest_.update(state, last)) return;
  cycle_.rest_speed = rest_.speed();
  cycle_.rested = rest_.rested();
  cycle_.rest_s = rest_.seconds();
  cycle_.drift_m = rest_.driftOf(state);
  cycle_.end_tick = state.tick;
  cycles_.push(cycle_);
  from_ = legs_.back();
  plan();
}

Pose SoakMotion::next(const State& state, const StepReport& last) {
  watch(state, last);
  if (leg_ == legs_.size()) return poseAt(from_, from_, 1);
  leg_time_ += tick_seconds_;
  const Leg& to = legs_[leg_];
  const Pose pose = poseAt(from_, to, std::min(1.0, leg_time_ / to.seconds));
  if (leg_time_ >= to.seconds) {
    from_ = to;
    leg_time_ = 0;
    ++leg_;
  }
  return pose;
}

}  // namespace palpate::app
