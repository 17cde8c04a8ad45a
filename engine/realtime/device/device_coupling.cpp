#include "realtime/device/device_coupling.h"

#include <algorithm>
#include <cmath>

#include "base/turn.h"
#include "realtime/channels/force_output.h"

namespace palpate {
namespace {

constexpr std::int64_t kLongestPause = 10'000'000'000;  // ns that the clock here goes on by at once
constexpr double kLongestCall = 0.01;               // s; a thread that was away longer starts anew in a moment anyway
constexpr double kContactSeconds = 0.005;           // for the coupling to come and go with the contact
constexpr double kVelocitySeconds = 0.004;          // smoothing of velocities made from an encoder's steps
constexpr double kIntervalShare = 0.02;             // of a new interval between poses in their mean
constexpr double kGap = 2.5;                        // intervals without a pose: some were lost
constexpr double kLike = 0.3;                       // of two intervals of one rate; poses are read each ms
constexpr double kSoftens = 0.02, kStiffens = 1.0;  // s, of the coupling when its delay changes
constexpr double kBraked = 0.1;    // m/s, up to which a handle that comes in is braked before it has paid
constexpr double kUnknown = 3e-4;  // J, that forces under way may give to a handle at full speed that turns back
// m and m/s: a handle that is further at once did not go there. (The quickest hands and falls: 3 m/s.)
constexpr double kPutElsewhere = 0.005, kQuickest = 10;
constexpr double kJumps = 3;  // times the tool's greatest speed: it was put elsewhere

double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

/// No longer than `most`.
Vec3 cut(const Vec3& v, double most) {
  const double size = v.norm();
  return size > most ? Vec3(most / size * v) : v;
}

/// The part of `way` that relaxes a spring stretched like this, as far as to its rest.
Vec3 relaxing(const Vec3& way, const Vec3& stretch) {
  const double size2 = stretch.squaredNorm();
  return size2 > 0 ? Vec3(std::clamp(way.dot(stretch) / size2, 0.0, 1.0) * stretch) : Vec3(Vec3::Zero());
}

}  // namespace

DeviceCoupling::DeviceCoupling(const DeviceSettings& settings, const Model& model)
    : settings_(settings),
      start_(model.tools.first().start.pose),
      rate_hz_(model.scene.dynamics.rate_hz),
      jump_(kJumps * model.scene.tools[0].max_speed / model.scene.dynamics.rate_hz),
      stiffness_(settings.stiffness) {
  target_.pose = start_;
  tool_ = start_;
}

/// Energy, velocity and interval of a new pose.
void DeviceCoupling::take(std::int64_t now, const DevicePose& pose) {
  if (report_.poses++ == 0) handle_ = pose;
  AlongAndTurning way;
  way.along = pose.pose.position - handle_.pose.position;
  way.turning = settings_.lever * turnBetween(handle_.pose.orientation, pose.pose.orientation);
  const double interval = std::max(1e-4, seconds(now - pose_ns_));
  const double farthest = std::max(kPutElsewhere, kQuickest * interval);
  if (way.along.norm() > farthest || way.turning.norm() > farthest) {
    if (phase_ == Phase::Engaged) stayWhile(pose);
    way = {};
  }
  // A slow device has like intervals, one that lost poses has not.
  const bool regular = interval <= slowest_period && std::abs(interval - last_interval_) < kLike * interval;
  last_interval_ = interval;
  const bool gap = report_.poses == 1 || (!regular && interval > std::max(silent_seconds, kGap * interval_s_));
  energy_.moved(now, pose.felt, way, interval, gap);
  // A slow device is silent until it is known as one: five times as quickly.
  if (!gap) interval_s_ += (regular && interval > interval_s_ ? 5 : 1) * kIntervalShare * (interval - interval_s_);
  // By the device's clock: the way here takes now longer, now shorter.
  const double told = seconds(pose.sent_ns - handle_.sent_ns);
  const double taken = told > 1e-5 && told < 10 * silent_seconds ? told : interval;
  if (interval > silence()) {
    velocity_ = newest_velocity_ = {};
  } else {
    newest_velocity_ = {way.along / taken, way.turning / taken};
    const double share = -std::expm1(-taken / kVelocitySeconds);
    velocity_.along += share * (newest_velocity_.along - velocity_.along);
    velocity_.turning += share * (newest_velocity_.turning - velocity_.turning);
  }
  if (pose.has_velocity) velocity_.along = newest_velocity_.along = pose.velocity;
  speed_ = std::max(velocity_.along.norm(), speed_ * std::exp(-taken / unknown()));
  handle_ = pose;
  pose_ns_ = now;
}

/// The handle is told to be elsewhere: no hand goes there so quickly, and no force does work on that way. The spring's
/// end stays, as if it had slipped.
void DeviceCoupling::stayWhile(const DevicePose& pose) {
  slack_ -= settings_.scale * (pose.pose.position - handle_.pose.position);
  turned_ = (turned_ * handle_.pose.orientation * pose.pose.orientation.conjugate()).normalized();
}

/// s without a pose, from which on the device is silent.
double DeviceCoupling::silence() const {
  return std::max(silent_seconds, kGap * std::min(interval_s_, slowest_period));
}

/// s, for which it isn't known what the handle does with a force.
double DeviceCoupling::unknown() const {
  return energy_.told() ? energy_.delay() + 1.5 * interval_s_ : PortEnergy::longest_assumed_s;
}

/// @return false where the tool can't be gone by: late, frozen, or put elsewhere since the last call
bool DeviceCoupling::followTool(std::int64_t now, const ForceReading& reading, std::uint32_t put_backs) {
  const ForceSample& tool = reading.sample;
  if (tool.tick <= 0) return false;
  const bool known = tool_tick_ > 0;
  const std::int64_t ticks = tool.tick - tool_tick_;
  const Vec3 way = tool.tool_pose.position - tool_.position;
  const bool put_back = known && (tool.loss_count != losses_ || put_backs != put_backs_ || ticks < 0 ||
                                  way.norm() > jump_ * std::max<double>(1, static_cast<double>(ticks)));
  if (known && ticks > 0 && !put_back) {
    const double per_second = rate_hz_ / static_cast<double>(ticks);
    tool_velocity_.along = per_second * way;
    tool_velocity_.turning = per_second * settings_.lever * turnBetween(tool_.orientation, tool.tool_pose.orientation);
  } else if (!known || put_back) {
    tool_velocity_ = {};
  }
  if (ticks != 0) tool_ns_ = now;
  tool_ = tool.tool_pose;
  tool_tick_ = tool.tick;
  losses_ = tool.loss_count;
  put_backs_ = put_backs;
  touching_ = tool.contact_count > 0 || !tool.force_raw.isZero(0);
  if (!tool.contact_normal.isZero(0)) normal_ = tool.contact_normal;
  if (put_back) lost_ = true;
  return !put_back && reading.fresh && !tool.frozen;
}

/// Where both are, with the force that is out.
void DeviceCoupling::engage() {
  if (!anchored_) first_ = handle_.pose;
  anchored_ = true;
  phase_ = Phase::Engaged;
  contact_ = touching_ ? 1 : 0;
  slack_.setZero();
  turned_.setIdentity();
  placeTarget();
  const double reach = settings_.scale / stiffness_;
  slip({tool_.position - target_.pose.position - reach * force_.along,
        settings_.lever * turnBetween(target_.pose.orientation, tool_.orientation) - force_.turning / stiffness_});
  energy_.holdAtMost(0.5 * force_.dot(force_) / stiffness_);
}

/// To what the way's delay allows.
void DeviceCoupling::soften(double step) {
  const double delay = 0.5 * interval_s_ + energy_.delay();
  const double wanted =
      std::min({settings_.stiffness, settings_.own_damping / delay, lightest_handle / (delay * delay)});
  stiffness_ += (wanted - stiffness_) * std::min(1.0, step / (wanted < stiffness_ ? kSoftens : kStiffens));
}

/// The spring's end: where the handle will be when the force of now reaches it, and what has slipped.
void DeviceCoupling::placeTarget() {
  const double ahead = energy_.delay();
  target_.pose.position = toWorld(handle_.pose.position + ahead * velocity_.along) + slack_;
  target_.velocity = settings_.scale * velocity_.along;
  if (settings_.locked) {
    target_.pose.orientation = start_.orientation;
  } else {
    const Quat turn = handle_.pose.orientation * first_.orientation.conjugate();
    target_.pose.orientation =
        (turned_ * turnedBy(ahead / settings_.lever * velocity_.turning) * turn * start_.orientation).normalized();
    target_.turning = velocity_.turning / settings_.lever;
  }
  // N per m of the tool, whose way is `scale` times the device's; turns are not scaled, so torques are.
  target_.stiffness = stiffness_ / settings_.scale;
  target_.damping = settings_.damping / settings_.scale;
  const double turning = settings_.locked ? 0 : settings_.scale * settings_.lever * settings_.lever;
  target_.turning_stiffness = turning * stiffness_;
  target_.turning_damping = turning * settings_.damping;
  target_.sequence = handle_.sequence;
}

/// How far it is stretched, m: from its end to the tool.
AlongAndTurning DeviceCoupling::spring(std::int64_t now) const {
  // Between two ticks the tool goes on as it went, or each of them would be a step in the force.
  const double since = std::clamp(seconds(now - tool_ns_), 0.0, 1 / rate_hz_);
  AlongAndTurning stretch;
  stretch.along = tool_.position + since * tool_velocity_.along - target_.pose.position;
  if (!settings_.locked)
    stretch.turning =
        settings_.lever * turnBetween(target_.pose.orientation, tool_.orientation) + since * tool_velocity_.turning;
  return stretch;
}

/// Moves the spring's end.
void DeviceCoupling::slip(const AlongAndTurning& way) {
  slack_ += way.along;
  target_.pose.position += way.along;
  if (settings_.locked) return;
  const Quat turn = turnedBy(way.turning / settings_.lever);
  turned_ = (turn * turned_).normalized();
  target_.pose.orientation = (turn * target_.pose.orientation).normalized();
}

/// In air, and in contact as far as it charges no spring.
void DeviceCoupling::giveSlackBack(const AlongAndTurning& stretch, double step) {
  const double share = -std::expm1(-step / slack_seconds);
  AlongAndTurning back;
  back.along = -share * slack_;
  back.turning = -share * settings_.lever * turnBetween(Quat::Identity(), turned_);
  if (touching_ || contact_ > 0) {
    back.along = relaxing(back.along, stretch.along);
    back.turning = relaxing(back.turning, stretch.turning);
  }
  slip(back);
}

AlongAndTurning DeviceCoupling::coupling(std::int64_t now, double step) {
  soften(step);
  const double change = step / kContactSeconds;
  contact_ = std::clamp(contact_ + (touching_ ? change : -change), 0.0, 1.0);
  if (contact_ <= 0) energy_.forget();
  energy_.forgive(step);
  report_.energy_J = energy_.pushed();
  report_.lowest_energy_J = std::min(report_.lowest_energy_J, report_.energy_J);

  placeTarget();
  giveSlackBack(spring(now), step);
  AlongAndTurning stretch = spring(now), force;
  force.along = target_.stiffness * stretch.along + target_.damping * (tool_velocity_.along - target_.velocity);
  force.turning = stiffness_ * stretch.turning + settings_.damping * (tool_velocity_.turning - velocity_.turning);
  if (settings_.locked) force.turning.setZero();
  force.along *= contact_;
  force.turning *= contact_;
  if (const double pull = force.along.dot(normal_); pull < 0) force.along -= pull * normal_;
  force = limited(force, step);
  pay(now, force);
  return force;
}

/// Cuts a force down to what the hand has paid for; what stretched the spring further slips.
void DeviceCoupling::pay(std::int64_t now, AlongAndTurning& force) {
  const double horizon = energy_.delay() + 1.5 * interval_s_;
  // Forces under way meet a handle that may have turned back.
  if (speed_ > 0) force.along = cut(force.along, kUnknown / (speed_ * unknown()));
  const double stiffness = 1 / (1 / stiffness_ + horizon * horizon / lightest_handle);
  const double damping = std::min(settings_.own_damping, 0.5 * lightest_handle / horizon);
  const auto slipped = [&](Vec3& part, double energy, const Vec3& velocity) {
    const double size = part.norm(), paid = energy / free_energy_J + 1;
    if (size <= 0) return Vec3(Vec3::Zero());
    const double in = std::clamp(-velocity.dot(part) / size, 0.0, kBraked);
    const double most =
        std::sqrt(2 * stiffness * free_energy_J * std::max(0.0, paid)) + std::clamp(1 + paid, 0.0, 1.0) * damping * in;
    if (size <= most) return Vec3(Vec3::Zero());
    const Vec3 way = (1 - most / size) / stiffness_ * part;
    report_.damped_J += way.dot(part);
    part *= most / size;
    return way;
  };
  AlongAndTurning way;
  const double pushed = energy_.pushed() - energy_.underway(now, newest_velocity_, true);
  way.along = settings_.scale * slipped(force.along, pushed, velocity_.along);
  const double left = energy_.all() - energy_.underway(now, newest_velocity_, false);
  way.turning = slipped(force.turning, left - 0.5 * force.along.squaredNorm() / stiffness, velocity_.turning);
  slip(way);
}

/// No longer than the device may push, and no quicker than it may rise.
AlongAndTurning DeviceCoupling::limited(const AlongAndTurning& wanted, double step) const {
  const double reach = settings_.max_force / settings_.rise_time * step;
  const auto limit = [&](const Vec3& to, const Vec3& from) {
    return Vec3(from + cut(cut(to, settings_.max_force) - from, reach));
  };
  return {limit(wanted.along, force_.along), limit(wanted.turning, force_.turning)};
}

DeviceWrench DeviceCoupling::update(std::int64_t told, const DevicePose* pose, const ForceSample& tool,
                                    std::uint32_t put_backs) {
  // Of times that run back no energy could be told.
  const std::int64_t gone = told_ == 0 ? 0 : std::clamp<std::int64_t>(told - told_, 0, kLongestPause);
  told_ = told;
  const std::int64_t now = now_ += gone;
  const double step = std::min(seconds(gone), kLongestCall);
  if (pose != nullptr) take(now, *pose);
  const bool alive = report_.poses > 0 && seconds(now - pose_ns_) <= silence();
  const bool usable = followTool(now, readForce(tool, told, rate_hz_), put_backs);

  if (phase_ == Phase::Engaged && !(alive && usable)) {
    ++(alive ? report_.fades : report_.silences);
    phase_ = Phase::Fading;
    phase_ns_ = now;
    held_ = force_;
  }
  if (phase_ == Phase::Fading) {
    const double left = std::max(0.0, 1 - seconds(now - phase_ns_) / fade_seconds);
    force_ = {left * held_.along, left * held_.turning};
    if (left <= 0) phase_ = Phase::Off, lost_ = false;
  }
  if (phase_ == Phase::Off) force_ = {};
  if ((phase_ == Phase::Off || (phase_ == Phase::Fading && !lost_)) && alive && usable) engage();
  if (phase_ == Phase::Engaged) force_ = coupling(now, step);
  target_.engaged = phase_ == Phase::Engaged;

  const bool in_air = !touching_ && force_.along.isZero(0) && force_.turning.isZero(0);
  calm_s_ = in_air ? calm_s_ + step : 0;
  if (calm_s_ > calm_seconds) energy_.beginAnew();

  DeviceWrench wrench;
  wrench.sequence = ++sequence_;
  wrench.answers = handle_.sequence;
  wrench.sent_ns = told;
  wrench.force = force_.along;
  wrench.torque = settings_.lever * force_.turning;
  wrench.touching = touching_;
  wrench.doubted = tool.doubt != Doubt::None;
  wrench.short_of_force = lacking() > felt_lacking;
  if (wrench.short_of_force) report_.lacking_s += step;
  energy_.sent(sequence_, now, force_);
  report_.peak_force = std::max(report_.peak_force, wrench.force.norm());
  report_.peak_torque = std::max(report_.peak_torque, wrench.torque.norm());
  return wrench;
}

double DeviceCoupling::lacking() const {
  if (phase_ != Phase::Engaged || contact_ <= 0) return 0;
  const double lost = stiffness_ / settings_.scale * slack_.norm();
  return lost > 0 ? lost / (lost + force_.along.norm()) : 0;
}

DeviceReport DeviceCoupling::report() const {
  DeviceReport report = report_;
  report.delay_s = energy_.delay();
  report.stiffness = stiffness_;
  report.slipped_m = slack_.norm();
  report.lacking = lacking();
  report.engaged = phase_ == Phase::Engaged;
  return report;
}

}  // namespace palpate
