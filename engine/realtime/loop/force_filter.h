#pragma once

#include "base/types.h"

namespace palpate {

/// Makes the raw contact force fit for a hand: a first-order low-pass, then a limit
/// on the rate of change. The raw force is handed on beside it, unchanged.
///
///   g_k = g_(k-1) + (1 - exp(-2 pi f_c / rate)) (raw_k - g_(k-1))     exact for a held input
///   out_k = out_(k-1) + clamp(g_k - out_(k-1), rate_limit / rate)     in norm
///
/// Real-time: no allocation, no lock, no throw.
class ForceFilter {
 public:
  /// @param cutoff_hz   -3 dB frequency; 0: no low-pass
  /// @param rate_limit  N/s; 0: no limit
  /// @param rate_hz     ticks per second
  ForceFilter(double cutoff_hz, double rate_limit, double rate_hz);

  /// One tick: the filtered force for the raw one, N. After a fade it goes on from
  /// the value that the ramp has reached.
  Vec3 update(const Vec3& raw);

  /// One tick while the tissue is frozen: from the present value to exactly zero along
  /// a smooth ramp of at least fade_seconds that keeps the rate limit. The first call
  /// after update() starts the ramp.
  Vec3 fade();

  const Vec3& value() const { return out_; }

  static constexpr double fade_seconds = 0.25;

 private:
  double gain_;        // of the low-pass per tick
  double max_change_;  // N per tick
  double rate_hz_;
  Vec3 low_pass_ = Vec3::Zero();
  Vec3 out_ = Vec3::Zero();
  Vec3 fade_from_ = Vec3::Zero();
  int fade_tick_ = 0;  // 0: not fading
  int fade_ticks_ = 0;
};

}  // namespace palpate
