#include "realtime/device/coupled_tool.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/turn.h"

namespace palpate {
namespace {

constexpr double kReleaseSeconds = 0.02;  // in air, until the tool is free of the tissue's damping
constexpr double kRattleSeconds = 1;      // until what a rattle has shown is forgotten
constexpr double kRattleWay = 1e-7;       // m in a tick; less is rounding
constexpr double kMostHolds = 4;          // times what a rattle may show the tissue to be stiffer than expected
constexpr int kRattles = 2;               // reversals in a row that are one

}  // namespace

double RattleWatch::see(const Vec3& way, const Vec3& force, double most, double tick_s) {
  stiffness_ *= 1 - tick_s / kRattleSeconds;
  const double length = way.norm();
  if (length < kRattleWay) return stiffness_;
  reversals_ = way.dot(last_way_) < 0 ? reversals_ + 1 : 0;
  last_way_ = way;
  if (reversals_ >= kRattles) stiffness_ = std::min(most, std::max(stiffness_, -force.dot(way) / (length * length)));
  return stiffness_;
}

CoupledTool::CoupledTool(const Model& model)
    : tick_s_(1 / model.scene.dynamics.rate_hz), widest_(model.tools.first().start.opening) {
  const double R = model.scene.tools[0].shape.radius, area = std::numbers::pi * R * R;
  for (const Material& m : model.materials) {
    const double K = m.bulk_modulus, G = m.shear_modulus;
    const double young = 9 * K * G / (3 * K + G), poisson = (3 * K - 2 * G) / (2 * (3 * K + G));
    const double punch = 2 * R * young / (1 - poisson * poisson);
    normal_hold_ = std::max(normal_hold_, std::sqrt(m.waveModulus() * m.density) * area / tick_s_ + punch);
    tangent_hold_ = std::max(tangent_hold_, std::sqrt(G * m.density) * area / tick_s_ + punch);
    turning_hold_ = std::max(
        turning_hold_, R * R * (0.25 * std::sqrt(m.waveModulus() * m.density) * area / tick_s_ + 2.0 / 3 * punch));
  }
}

Pose CoupledTool::next(const State& state, const StepReport& last) {
  const DeviceTarget& target = targets_.latest();
  if (!target.engaged) return state.tool[0].pose;
  sequence_ = target.sequence;
  moveJaws(target.closes, state.tool[0].opening);
  const bool touches = !last.tool_force.isZero(0);
  hold_ = touches ? 1 : std::max(0.0, hold_ - tick_s_ / kReleaseSeconds);
  if (touches) normal_ = last.contact_normal.isZero(0) ? last.tool_force.normalized() : last.contact_normal;
  Pose pose = target.pose;
  const Vec3& x = state.tool[0].pose.position;
  if (hold_ <= 0) {
    along_watch_.forget();
    across_watch_.forget();
    turning_watch_.forget();
    remember(state, last);
    return pose;
  }
  const Vec3 way = x - last_x_, change = last.tool_force - last_force_;
  const Vec3 way_along = way.dot(normal_) * normal_;
  const double most = kMostHolds * normal_hold_;
  const double rattle_along = along_watch_.see(way_along, change, most, tick_s_);
  const double rattle_across = across_watch_.see(way - way_along, change, most, tick_s_);
  if (target.turning_stiffness > 0) pose.orientation = turned(target, state, last);
  remember(state, last);
  const Vec3 push = target.stiffness * (target.pose.position - x) + target.damping * target.velocity + last.tool_force;
  const double spring = target.stiffness + target.damping / tick_s_;
  const double along = push.dot(normal_);
  const double sticks = state.live.friction[0] > 0 ? hold_ : 0;
  pose.position = x + (along / (spring + hold_ * std::max(normal_hold_, rattle_along))) * normal_ +
                  (push - along * normal_) / (spring + sticks * tangent_hold_ + hold_ * rattle_across);
  return pose;
}

/// The same balance of torques.
Quat CoupledTool::turned(const DeviceTarget& target, const State& state, const StepReport& last) {
  const Quat& q = state.tool[0].pose.orientation;
  const double rattle =
      turning_watch_.see(turnBetween(last_q_, q), last.tool_torque - last_torque_, kMostHolds * turning_hold_, tick_s_);
  const Vec3 push = target.turning_stiffness * turnBetween(q, target.pose.orientation) +
                    target.turning_damping * target.turning + last.tool_torque;
  const double spring = target.turning_stiffness + target.turning_damping / tick_s_;
  return (turnedBy(push / (spring + hold_ * std::max(turning_hold_, rattle))) * q).normalized();
}

/// They open from where tissue has held them apart, if that is wider than where they were to be.
void CoupledTool::moveJaws(bool closes, double present) {
  if (opening_ < 0 && !closes) return;
  if (opening_ < 0) opening_ = present;
  const double way = jaw_speed * tick_s_;
  opening_ =
      closes ? std::max(0.0, opening_ - way) : std::min(std::max(widest_, opening_), std::max(opening_, present) + way);
}

void CoupledTool::remember(const State& state, const StepReport& last) {
  last_x_ = state.tool[0].pose.position;
  last_q_ = state.tool[0].pose.orientation;
  last_force_ = last.tool_force;
  last_torque_ = last.tool_torque;
}

}  // namespace palpate
