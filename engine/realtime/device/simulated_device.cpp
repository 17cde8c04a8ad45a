#include "realtime/device/simulated_device.h"

#include <algorithm>
#include <cmath>

#include "base/turn.h"

namespace palpate {

SimulatedDeviceSettings SimulatedDeviceSettings::of(int device_class) {
  SimulatedDeviceSettings device;  // light
  if (device_class == 1) {
    device.mass = 0.09, device.damping = 0.2, device.friction = 0.06;
    device.encoder_step = 3e-5, device.max_force = 8;
  }
  if (device_class == 2) {
    device.mass = 0.2, device.damping = 0.4, device.friction = 0.2;
    device.encoder_step = 1e-5, device.max_force = 12;
  }
  return device;
}

void SimulatedDevice::step() {
  const std::int64_t now =
      begin_ns_ + static_cast<std::int64_t>(std::llround(1e9 * step_s * static_cast<double>(steps_)));
  for (WrenchUnderway& w : wrenches_) {
    if (w.arrives < 0 || w.arrives > now) continue;
    if (w.wrench.sequence > force_.sequence) force_ = w.wrench;  // one that was overtaken is dropped
    w.arrives = -1;
    if (const double size = force_.force.norm(); size > device_.max_force) force_.force *= device_.max_force / size;
    const double most = device_.turns_hand ? device_.max_force * device_.lever : 0;
    if (const double size = force_.torque.norm(); size > most) force_.torque *= most / size;
  }
  const Vec3 wanted = motion_.at(step_s * static_cast<double>(steps_));
  const Vec3 grip = hand_.grip_stiffness * (arm_x_ - x_) + hand_.grip_damping * (arm_v_ - v_);
  const Vec3 arm = hand_.arm_stiffness * (wanted - arm_x_) - hand_.arm_damping * arm_v_;
  arm_v_ += step_s / hand_.mass * (arm - grip);
  v_ += step_s / device_.mass * (force_.force + grip - device_.damping * v_);
  // Coulomb friction stops the handle where it is stronger than all else, and never turns it back.
  const double stop = step_s * device_.friction / device_.mass, speed = v_.norm();
  v_ = speed > stop ? Vec3((1 - stop / speed) * v_) : Vec3::Zero();
  arm_x_ += step_s * arm_v_;
  x_ += step_s * v_;
  const double per_lever2 = 1 / (device_.lever * device_.lever);
  const Vec3 turned = hand_.grip_stiffness * (motion_.turnAt(step_s * static_cast<double>(steps_)) - turn_) -
                      (hand_.grip_damping + device_.damping) * turning_;
  turning_ += step_s / device_.mass * (per_lever2 * force_.torque + turned);
  turn_ += step_s * turning_;
  work_ += step_s * (force_.force.dot(v_) + force_.torque.dot(turning_));
  ++steps_;
}

void SimulatedDevice::sendPose() {
  DevicePose pose;
  pose.sequence = ++sent_;
  if (device_.tells_felt) pose.felt = force_.sequence;
  pose.sent_ns = static_cast<std::int64_t>(std::llround(1e9 * step_s * static_cast<double>(steps_)));
  for (int c = 0; c < 3; ++c) pose.pose.position[c] = device_.encoder_step * std::round(x_[c] / device_.encoder_step);
  pose.pose.orientation = turnedBy(turn_);
  if (silent_) return;
  for (PoseUnderway& p : poses_) {
    if (p.arrives >= 0) continue;
    p = {begin_ns_ + pose.sent_ns + way(), pose};
    return;
  }
}

bool SimulatedDevice::read(std::int64_t now_ns, DevicePose& pose) {
  constexpr std::int64_t kLongestAway = 2000;  // steps: who asks again after a longer time finds the hand where it was
  if (!begun_) {
    begun_ = true;
    begin_ns_ = now_ns;
    sendPose();
  }
  const auto due =
      static_cast<std::int64_t>(std::floor(1e-9 * static_cast<double>(now_ns - begin_ns_) / step_s + 1e-6));
  if (due - steps_ > kLongestAway) begin_ns_ += static_cast<std::int64_t>(1e9 * step_s) * (due - steps_ - kLongestAway);
  const auto per_pose = static_cast<std::int64_t>(std::llround(1 / (device_.rate_hz * step_s)));
  for (std::int64_t k = std::min(due - steps_, kLongestAway); k > 0; --k) {
    step();
    if (steps_ % per_pose == 0) sendPose();
  }
  bool news = false;
  for (PoseUnderway& p : poses_) {
    if (p.arrives < 0 || p.arrives > now_ns) continue;
    p.arrives = -1;
    if (p.pose.sequence <= read_) continue;
    read_ = p.pose.sequence;
    pose = p.pose;
    news = true;
  }
  return news;
}

void SimulatedDevice::write(std::int64_t now_ns, const DeviceWrench& wrench) {
  for (WrenchUnderway& w : wrenches_) {
    if (w.arrives >= 0) continue;
    w = {now_ns + way(), wrench};
    return;
  }
}

}  // namespace palpate
