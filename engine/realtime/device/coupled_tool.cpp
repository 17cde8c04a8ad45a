#include "realtime/device/coupled_tool.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

constexpr double kReleaseSeconds = 0.02;  // in air, until the tool is free of the tissue's damping

}  // namespace

CoupledTool::CoupledTool(const Model& model) : tick_s_(1 / model.scene.rate_hz) {
  const double R = model.scene.tool.radius, area = std::numbers::pi * R * R;
  for (const Material& m : model.materials) {
    const double K = m.bulk_modulus, G = m.shear_modulus;
    const double young = 9 * K * G / (3 * K + G), poisson = (3 * K - 2 * G) / (2 * (3 * K + G));
    const double punch = 2 * R * young / (1 - poisson * poisson);
    normal_hold_ = std::max(normal_hold_, std::sqrt(m.waveModulus() * m.density) * area / tick_s_ + punch);
    tangent_hold_ = std::max(tangent_hold_, std::sqrt(G * m.density) * area / tick_s_ + punch);
  }
}

Pose CoupledTool::next(const State& state, const StepReport& last) {
  const DeviceTarget& target = targets_.latest();
  if (!target.engaged) return state.tool_pose;
  sequence_ = target.sequence;
  const bool touches = !last.tool_force.isZero(0);
  hold_ = touches ? 1 : std::max(0.0, hold_ - tick_s_ / kReleaseSeconds);
  if (touches) normal_ = last.contact_normal.isZero(0) ? last.tool_force.normalized() : last.contact_normal;
  Pose pose = target.pose;
  if (hold_ <= 0) return pose;

  const Vec3& x = state.tool_pose.position;
  const Vec3 push = target.stiffness * (target.pose.position - x) + target.damping * target.velocity + last.tool_force;
  const double spring = target.stiffness + target.damping / tick_s_;
  const double along = push.dot(normal_);
  const double sticks = state.live.friction > 0 ? hold_ : 0;
  pose.position = x + (along / (spring + hold_ * normal_hold_)) * normal_ +
                  (push - along * normal_) / (spring + sticks * tangent_hold_);
  return pose;
}

}  // namespace palpate
