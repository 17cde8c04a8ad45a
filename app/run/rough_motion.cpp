#include "app/run/rough_motion.h"

#include <algorithm>

#include "mechanics/materials/material.h"
#include "realtime/loop/fold_watch.h"

namespace palpate::app {
namespace {

constexpr double kRoughAway = 1.0;         // m/s, lifting off
constexpr double kRoughDraw = 0.1;         // m/s, while a fold hangs on the tool
constexpr double kRoughPatience = 2;       // s, until it tries the other way,
constexpr double kRoughLongPatience = 10;  // s, and then each time: a tool may be slow
// In the frame of the tool's start: upwards, downwards, aside, and upwards again; then it waits.
const std::array<Vec3, 7> kRoughWaysOut = {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(-1, 0, 0),
                                           Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1)};
constexpr double kRoughPressSlow = 0.05, kRoughPressFast = 0.3;  // m/s
constexpr double kRoughDragSlow = 0.05, kRoughDragFast = 0.5;    // m/s
constexpr double kRoughShortHold = 0.05, kRoughLongHold = 0.4;   // s
constexpr double kRoughSoft = 0.5;                               // of the scene's stiffness
constexpr double kRoughBeyond = 0.1;                             // of the organ's size: so far out pokes and jumps end

}  // namespace

RoughMotion::RoughMotion(const Body& model, unsigned seed, int most_nodes)
    : start_(model.tools.first().start.pose),
      tick_seconds_(1 / model.scene.dynamics.rate_hz),
      materials_(model.materials),
      seed_(seed),
      rest_(model, RestWatch::rest_hold_s + FoldWatch::seconds, most_nodes),  // what has folded is put back before
      random_(seed) {
  low_ = high_ = start_.toLocal(model.skin.surface.vertices.front());
  for (const Vec3& X : model.skin.surface.vertices) {
    low_ = low_.cwiseMin(start_.toLocal(X));
    high_ = high_.cwiseMax(start_.toLocal(X));
  }
  lift_ = high_.z() + 0.5 * model.scene.tools[0].shape.radius;
  planRound();
}

double RoughMotion::uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }

/// Somewhere over, in or under the organ: its height is this share of the organ's, from the bottom.
Vec3 RoughMotion::place(double low_share, double high_share) {
  const double x = uniform(low_.x(), high_.x()), y = uniform(low_.y(), high_.y());
  return slid_ + Vec3(x, y, low_.z() + uniform(low_share, high_share) * (high_.z() - low_.z()));
}

void RoughMotion::planAct() {
  Vec3 top = place(0, 0);
  top.z() = lift_;
  Vec3 inside = place(0, 0.9);
  const double hold = uniform(kRoughShortHold, kRoughLongHold);
  switch (random_() % 4) {
    case 0:  // a poke through the bottom, and out at once
      add(top, 0, 0);
      add({top.x(), top.y(), low_.z() - kRoughBeyond * (high_.z() - low_.z())}, poke_speed,
          uniform(0, kRoughShortHold));
      return add(top, poke_speed, 0);
    case 1:  // a press that is held
      add(top, kRoughAway, 0);
      return add({top.x(), top.y(), inside.z()}, uniform(kRoughPressSlow, kRoughPressFast), hold);
    case 2:  // a drag from wherever the hand is
      return add(inside, uniform(kRoughDragSlow, kRoughDragFast), 0);
    default:  // a jump
      return add(place(-kRoughBeyond, 1 + kRoughBeyond), 0, hold);
  }
}

void RoughMotion::planSettings() {
  setting_ = setting_count_ = 0;
  settings_[setting_count_++] = Request::setFriction(uniform(0, 1));
  const std::size_t m = random_() % materials_.size();
  const double stiffness = random_() % 2 == 0 ? 1 : kRoughSoft;
  settings_[setting_count_++] = Request::setMaterial(static_cast<int>(m), stiffened(materials_[m], stiffness));
}

void RoughMotion::planRound() {
  leg_ = leg_count_ = 0;
  const std::size_t acts = 2 + random_() % (most_acts - 1);
  for (std::size_t a = 0; a < acts; ++a) planAct();
  Vec3 away = legs_[leg_count_ - 1].goal;
  away.z() = lift_;
  add(away, kRoughAway, 0);
  held_ = touched_ = 0;
  tries_ = 0;
  rest_.begin();
  planSettings();
  cycle_ = {.number = cycle_.number + 1};
}

void RoughMotion::restart() {
  random_.seed(seed_);
  hand_.setZero();
  slid_.setZero();
  cycle_ = {};
  rest_.forgetFirst();
  planRound();
}

const Request* RoughMotion::nextSetting() {
  if (setting_ == setting_count_) return nullptr;
  return &settings_[setting_++];
}

/// m along `way`, to where it goes if the skin hangs on the tool: the organ's size beyond it.
double RoughMotion::endOf(const Vec3& way) const {
  const Vec3 corner = (way.array() > 0).select(Vec3(high_.x(), high_.y(), lift_), low_);
  return way.dot(slid_ + corner) + (high_ - low_).norm();
}

/// A tool that came up beneath a fold carries it; a hand would draw it out. One that came up beneath the organ lifts it
/// until it can push no harder, and has to go back; one in an organ that slides takes it along, and has to go where it
/// can't follow. If it was freed meanwhile by putting the tissue back to rest, it is above the organ again, and would
/// press on it for ever.
bool RoughMotion::stillLifts(const StepReport& last) {
  if (last.contact_count == 0 || tries_ == kRoughWaysOut.size()) return false;
  const Vec3& way = kRoughWaysOut[tries_];
  if (way.dot(hand_) < endOf(way)) {
    hand_ += (way.z() < 0 ? kRoughAway : kRoughDraw) * tick_seconds_ * way;
  } else if ((touched_ += tick_seconds_) >= (tries_ == 0 ? kRoughPatience : kRoughLongPatience)) {
    touched_ = 0;
    ++tries_;
  }
  rest_.begin();
  return true;
}

void RoughMotion::watch(const State& state, const StepReport& last) {
  addTick(cycle_, last);
  if (leg_ < leg_count_ || stillLifts(last) || !rest_.update(state, last)) return;
  cycle_.rest_speed = rest_.speed();
  cycle_.rested = rest_.rested();
  cycle_.still_s = rest_.rested() ? rest_.hold() : 0;
  cycle_.rest_s = rest_.seconds();
  cycle_.drift_m = rest_.driftOf(state);
  cycle_.end_tick = state.tick;
  cycles_.push(cycle_);
  slid_ = start_.orientation.conjugate() * rest_.slidOf(state);
  planRound();
}

void RoughMotion::advance() {
  if (leg_ == leg_count_) return;  // resting
  const Leg& leg = legs_[leg_];
  const Vec3 way = leg.goal - hand_;
  const double reach = leg.speed * tick_seconds_, distance = way.norm();
  if (leg.speed > 0 && distance > reach) {
    hand_ += reach / distance * way;
    return;
  }
  hand_ = leg.goal;
  held_ += tick_seconds_;
  if (held_ < leg.hold) return;
  held_ = 0;
  ++leg_;
}

Pose RoughMotion::next(const State& state, const StepReport& last) {
  watch(state, last);
  advance();
  Pose pose = start_;
  pose.position = start_.toWorld(hand_);
  return pose;
}

}  // namespace palpate::app
