#include "realtime/device/device_coupling.h"

#include <algorithm>
#include <cmath>

#include "realtime/channels/force_output.h"

namespace palpate {
namespace {

constexpr double kLongestCall = 0.01;       // s; a thread that was away longer starts anew in a moment anyway
constexpr double kContactSeconds = 0.005;   // for the coupling to come and go with the contact
constexpr double kVelocitySeconds = 0.004;  // smoothing of velocities made from an encoder's steps
constexpr double kIntervalShare = 0.02;     // of a new interval between poses in their mean
constexpr double kDelayFalls = 0.2;         // 1/s: the delay that is reckoned with is nearly the longest of late
constexpr double kSoftens = 0.02, kStiffens = 1.0;  // s, of the coupling when its delay changes
constexpr double kJumps = 3;                        // times the tool's greatest speed: it was put elsewhere

double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

/// 1 to 0 over the time, gently at both ends.
double left(double time, double duration) {
  const double s = std::clamp(time / duration, 0.0, 1.0);
  return 1 - s * s * (3 - 2 * s);
}

}  // namespace

DeviceCoupling::DeviceCoupling(const DeviceSettings& settings, const Model& model)
    : settings_(settings),
      start_(model.tool_start),
      rate_hz_(model.scene.rate_hz),
      jump_(kJumps * model.scene.tool_max_speed / model.scene.rate_hz),
      stiffness_(settings.stiffness) {
  target_.pose = start_;
  tool_ = start_;
}

/// Energy, velocity and interval of a new pose.
void DeviceCoupling::take(std::int64_t now, const DevicePose& pose) {
  if (report_.poses++ == 0) handle_ = pose;
  const Vec3 way = pose.pose.position - handle_.pose.position;
  // The force that the hand worked against is the one that was out, not the one that this pose brings about.
  report_.energy_J -= force_.dot(way);
  const double interval = std::max(1e-4, seconds(now - pose_ns_));
  if (interval < silent_seconds) interval_s_ += kIntervalShare * (interval - interval_s_);
  // By the device's clock: the way here takes now longer, now shorter.
  const double told = seconds(pose.sent_ns - handle_.sent_ns);
  const double taken = told > 1e-5 && told < 10 * silent_seconds ? told : interval;
  if (pose.has_velocity)
    velocity_ = pose.velocity;
  else if (interval > silent_seconds)
    velocity_.setZero();
  else
    velocity_ -= std::expm1(-taken / kVelocitySeconds) * (way / taken - velocity_);
  handle_ = pose;
  pose_ns_ = now;
  if (pose.felt != 0) watchDelay(now, pose.felt);
}

/// There and back: the pose tells which force the handle had when it was measured.
void DeviceCoupling::watchDelay(std::int64_t now, std::uint32_t felt) {
  const std::uint32_t ago = sequence_ - felt;
  if (ago >= kRemembered) return;
  // The thread's own period lies between a force and the next look at poses, and is no delay of the way.
  const double delay = std::max(0.0, seconds(now - sent_ns_[felt % kRemembered]) - interval_s_);
  delay_s_ = std::max(delay, delay_s_ * (1 - kDelayFalls * interval_s_));
}

/// @return false where the tool can't be gone by: late, frozen, or put elsewhere since the last call
bool DeviceCoupling::followTool(std::int64_t now, const ForceSample& tool, std::uint32_t put_backs) {
  if (tool.tick <= 0) return false;
  const bool known = tool_tick_ > 0;
  const std::int64_t ticks = tool.tick - tool_tick_;
  const Vec3 way = tool.tool_pose.position - tool_.position;
  const bool put_back = known && (tool.loss_count != losses_ || put_backs != put_backs_ || ticks < 0 ||
                                  way.norm() > jump_ * std::max<double>(1, static_cast<double>(ticks)));
  if (known && ticks > 0 && !put_back)
    tool_velocity_ = way * rate_hz_ / static_cast<double>(ticks);
  else if (!known || put_back)
    tool_velocity_.setZero();
  if (ticks != 0) tool_ns_ = now;
  tool_ = tool.tool_pose;
  tool_tick_ = tool.tick;
  losses_ = tool.loss_count;
  put_backs_ = put_backs;
  touching_ = tool.contact_count > 0 || !tool.force_raw.isZero(0);
  return !put_back && readForce(tool, now, rate_hz_).fresh && !tool.frozen;
}

/// From rest: the device pulls from where the tool is.
void DeviceCoupling::engage(std::int64_t now) {
  if (!anchored_) first_ = handle_.pose;
  anchored_ = true;
  phase_ = Phase::Engaged;
  phase_ns_ = now;
  slack_ = tool_.position - toWorld(handle_.pose.position);
  contact_ = 0;
  force_.setZero();
}

Vec3 DeviceCoupling::coupling(std::int64_t now, double step) {
  const double allowed = settings_.own_damping / (0.5 * interval_s_ + delay_s_);
  const double wanted = std::min(settings_.stiffness, allowed);
  stiffness_ += (wanted - stiffness_) * std::min(1.0, step / (wanted < stiffness_ ? kSoftens : kStiffens));
  const double change = step / kContactSeconds;
  contact_ = std::clamp(contact_ + (touching_ ? change : -change), 0.0, 1.0);

  target_.engaged = true;
  target_.pose.position = toWorld(handle_.pose.position) + left(seconds(now - phase_ns_), slack_seconds) * slack_;
  target_.pose.orientation =
      (handle_.pose.orientation * first_.orientation.conjugate() * start_.orientation).normalized();
  target_.velocity = settings_.scale * velocity_;
  // N per m of the tool, whose way is `scale` times the device's.
  target_.stiffness = stiffness_ / settings_.scale;
  target_.damping = settings_.damping / settings_.scale;
  target_.sequence = handle_.sequence;
  // Between two ticks the tool goes on as it went, or each of them would be a step in the force.
  const double since = std::clamp(seconds(now - tool_ns_), 0.0, 1 / rate_hz_);
  const Vec3 tool = tool_.position + since * tool_velocity_;
  return contact_ *
         (target_.stiffness * (tool - target_.pose.position) + target_.damping * (tool_velocity_ - target_.velocity));
}

/// No longer than the device may push, and no quicker than it may rise.
Vec3 DeviceCoupling::limited(const Vec3& wanted, double step) const {
  Vec3 force = wanted;
  if (const double size = force.norm(); size > settings_.max_force) force *= settings_.max_force / size;
  const Vec3 change = force - force_;
  const double reach = settings_.max_force / settings_.rise_time * step;
  return change.norm() > reach ? Vec3(force_ + reach / change.norm() * change) : force;
}

/// Passivity observer and controller.
Vec3 DeviceCoupling::passive(const Vec3& force, double step) {
  double& energy = report_.energy_J;
  report_.lowest_energy_J = std::min(report_.lowest_energy_J, energy);
  if (contact_ <= 0) energy = std::min(energy, 0.0);
  const double v2 = velocity_.squaredNorm();
  if (energy >= 0 || v2 <= 0) return force;
  // A damper that acts late is stable as a spring is: below what device and hand have of themselves.
  const double alpha = std::min(-energy / (v2 * interval_s_), settings_.own_damping);
  report_.damped_J += alpha * v2 * step;
  return force - alpha * velocity_;
}

DeviceWrench DeviceCoupling::update(std::int64_t now, const DevicePose* pose, const ForceSample& tool,
                                    std::uint32_t put_backs) {
  const double step = now_ == 0 ? 0 : std::clamp(seconds(now - now_), 0.0, kLongestCall);
  now_ = now;
  if (pose != nullptr) take(now, *pose);
  const bool alive = report_.poses > 0 && seconds(now - pose_ns_) <= silent_seconds;
  const bool usable = followTool(now, tool, put_backs);

  if (phase_ == Phase::Off && alive && usable) engage(now);
  if (phase_ == Phase::Engaged && !(alive && usable)) {
    ++(alive ? report_.fades : report_.silences);
    phase_ = Phase::Fading;
    phase_ns_ = now;
    held_ = force_;
  }
  switch (phase_) {
    case Phase::Off:
      force_.setZero();
      break;
    case Phase::Engaged:
      force_ = limited(passive(coupling(now, step), step), step);
      break;
    case Phase::Fading:
      force_ = std::max(0.0, 1 - seconds(now - phase_ns_) / fade_seconds) * held_;
      if (force_.isZero(0)) phase_ = Phase::Off;
      break;
  }
  target_.engaged = phase_ == Phase::Engaged;
  report_.peak_force = std::max(report_.peak_force, force_.norm());

  DeviceWrench wrench;
  wrench.sequence = ++sequence_;
  wrench.answers = handle_.sequence;
  wrench.sent_ns = sent_ns_[sequence_ % kRemembered] = now;
  wrench.force = force_;
  wrench.touching = touching_;
  return wrench;
}

DeviceReport DeviceCoupling::report() const {
  DeviceReport report = report_;
  report.delay_s = delay_s_;
  report.stiffness = stiffness_;
  report.engaged = phase_ == Phase::Engaged;
  return report;
}

}  // namespace palpate
