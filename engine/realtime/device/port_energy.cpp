#include "realtime/device/port_energy.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kDelayFalls = 0.2;       // 1/s: the delay that is reckoned with is nearly the longest of late
constexpr double kMeanShare = 0.02;       // of a new interval between poses in their mean
constexpr double kSmoothSeconds = 0.002;  // of forces and ways alike, before they are multiplied
constexpr double kShown = 1e-4;           // J, given by one of the delays: it is believed
constexpr std::uint32_t kUndecided = 64;  // forces, until which a device that tells may not have had the first
constexpr double kForgivenWatts = 2e-5;   // 0.12 mJ in six seconds

double secondsOf(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

double shareIn(double seconds) { return -std::expm1(-seconds / kSmoothSeconds); }

template <class Accounts>
double leastOf(const Accounts& accounts) {
  double least = accounts[0].worst;
  for (const auto& account : accounts) least = std::min(least, account.worst);
  return least;
}

}  // namespace

void PortEnergy::sent(std::uint32_t sequence, std::int64_t now, const AlongAndTurning& force) {
  const Sent& before = at(newest_);
  const double share = newest_ == 0 ? 1 : shareIn(secondsOf(now - before.ns));
  AlongAndTurning smooth = before.smooth;
  smooth.along += share * (force.along - smooth.along);
  smooth.turning += share * (force.turning - smooth.turning);
  sent_[sequence % kRemembered] = {now, force, smooth};
  newest_ = sequence;
}

/// The newest force that was sent by then, no older than `from`.
std::uint32_t PortEnergy::newestBefore(std::int64_t ns, std::uint32_t from) const {
  std::uint32_t sequence = newest_ - from < kRemembered ? from : newest_ - static_cast<std::uint32_t>(kRemembered) + 1;
  while (sequence != newest_ && at(sequence + 1).ns <= ns) ++sequence;
  return sequence;
}

void PortEnergy::add(std::size_t k, std::uint32_t from, std::uint32_t to, const AlongAndTurning& way, bool gap) {
  if (newest_ - from >= kRemembered) from = newest_ - static_cast<std::uint32_t>(kRemembered) + 1, gap = true;
  double least_push = gap ? 0 : 1e9, least = least_push, sum_push = 0, sum = 0, count = 0;
  for (std::uint32_t s = from;; ++s) {
    const AlongAndTurning& force = gap ? at(s).force : at(s).smooth;
    const double push = -force.along.dot(way.along), all = -force.dot(way);
    least_push = std::min(least_push, push);
    least = std::min(least, all);
    sum_push += push, sum += all, ++count;
    if (s == to) break;
  }
  pushed_[k].add(least_push, gap ? least_push : sum_push / count);
  all_[k].add(least, gap ? least : sum / count);
}

void PortEnergy::moved(std::int64_t now, std::uint32_t felt, const AlongAndTurning& gone, double interval, bool gap) {
  behind_.along += gone.along, behind_.turning += gone.turning;
  const double share = gap ? 1 : shareIn(interval);
  const AlongAndTurning way{share * behind_.along, share * behind_.turning};
  behind_.along -= way.along, behind_.turning -= way.turning;
  if (!gap) interval_s_ += kMeanShare * (interval - interval_s_);
  const bool known = felt != 0 && newest_ - felt < kRemembered;
  if (known && !told_) delay_s_ = 0;
  if (known) {
    told_ = true;
    // A bridge that began anew, or that was silent for longer than is remembered, had no force that is known.
    const bool follows = felt_ != 0 && felt - felt_ < kRemembered;
    for (std::size_t k = 0; k < kAssumed; ++k) add(k, follows ? felt_ : felt, felt, way, gap || !follows);
    felt_ = felt;
    // The thread's own period lies between a force and the next look at poses, and is no delay of the way.
    const double delay = std::max(0.0, secondsOf(now - at(felt).ns) - interval_s_);
    if (gap) after_gap_ = newest_;
    const bool of_gap = static_cast<std::int32_t>(felt - after_gap_) <= 0;
    if (!gap && !(of_gap && delay > delay_s_))
      delay_s_ = std::max(sustained(delay), delay_s_ * (1 - kDelayFalls * interval_s_));
    assumed_felt_.fill(felt);
    return;
  }
  if (newest_ == 0) return;
  for (std::size_t k = 0; k < kAssumed; ++k) {
    const double delay = longest_assumed_s * static_cast<double>(k) / (kAssumed - 1);
    const std::uint32_t to = newestBefore(now - static_cast<std::int64_t>(1e9 * delay), assumed_felt_[k]);
    add(k, assumed_felt_[k], to, way, gap);
    assumed_felt_[k] = to;
  }
  if (told_ && !gap) told_ = false, delay_s_ = std::max(delay_s_, assumed_s);
  if (told_ || (felt_ == 0 && newest_ < kUndecided)) return;
  const auto least = std::min_element(pushed_.begin(), pushed_.end(),
                                      [](const Account& a, const Account& b) { return a.worst < b.worst; });
  const double shown = longest_assumed_s * static_cast<double>(least - pushed_.begin()) / (kAssumed - 1);
  const double falls = delay_s_ * (1 - kDelayFalls * interval_s_);
  delay_s_ = std::max({assumed_s, falls, least->worst < -kShown ? shown : 0});
}

/// The second longest of this one and those before it.
double PortEnergy::sustained(double delay) {
  constexpr int poses = 64;
  delays_.add(delay);
  Longest both = delays_before_;
  both.add(delays_.first);
  both.add(delays_.second);
  if (++delay_count_ == poses) delays_before_ = delays_, delays_ = {}, delay_count_ = 0;
  return both.second;
}

void PortEnergy::forget() { holdAtMost(0); }

void PortEnergy::beginAnew() {
  pushed_.fill({});
  all_.fill({});
}

void PortEnergy::holdAtMost(double energy) {
  for (auto* accounts : {&pushed_, &all_})
    for (Account& a : *accounts) a.worst = std::min(a.worst, energy), a.mean = std::min(a.mean, energy);
}

void PortEnergy::forgive(double time) {
  for (auto* accounts : {&pushed_, &all_})
    for (Account& a : *accounts) {
      a.worst += std::clamp(a.mean - a.worst, 0.0, kForgivenWatts * time);
      if (a.mean < 0) a.mean += std::min(-a.mean, kForgivenWatts * time);
    }
}

double PortEnergy::pushed() const { return leastOf(pushed_); }
double PortEnergy::all() const { return leastOf(all_); }

double PortEnergy::underway(std::int64_t now, const AlongAndTurning& velocity, bool push_alone) const {
  const std::uint32_t from = told_ ? felt_ : newestBefore(now - static_cast<std::int64_t>(1e9 * longest_assumed_s), 0);
  const AlongAndTurning& now_felt = at(told_ ? felt_ : newest_).force;
  double given = std::max(0.0, push_alone ? now_felt.along.dot(behind_.along) : now_felt.dot(behind_));
  std::int64_t until = now + static_cast<std::int64_t>(1e9 * interval_s_);
  for (std::uint32_t s = newest_; s != from && newest_ - s < kRemembered - 1 && s != 0; --s) {
    const double power = push_alone ? at(s).force.along.dot(velocity.along) : at(s).force.dot(velocity);
    given += std::max(0.0, power) * secondsOf(until - at(s).ns);
    until = at(s).ns;
  }
  return given;
}

}  // namespace palpate
