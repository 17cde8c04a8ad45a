#pragma once

#include <cstdint>

#include "realtime/channels/latest_words.h"
#include "realtime/channels/snapshot.h"

namespace palpate {

/// A force with its age, for those who feel or show it.
struct ForceReading {
  ForceSample sample;
  double age_s = 0;    // wall time since the begin of the tick that computed it
  bool fresh = false;  // computed, and no older than freshSeconds: fit for a hand
};

/// The age up to which a force is fresh, s: 10 ms, or three periods where they are longer (below 300 Hz).
/// A haptic device must not go on pushing with an older force: the hand has moved on. But in a loop that keeps its
/// deadlines a force may be two periods old: one to compute it, one until the next is done. The third is slack.
double freshSeconds(double rate_hz);

/// @param now      ns, by the clock of ForceSample::wall_ns, read after the sample was taken
/// @param rate_hz  of the loop that computes the force
ForceReading readForce(const ForceSample& sample, std::int64_t now, double rate_hz);

/// The newest force, from the loop to any number of readers (haptic device, viewer) on threads of their own
/// (LatestWords).
class ForceOutput {
 public:
  ForceOutput() { publish({}); }

  /// Writer. Real-time: no allocation, no lock, wait-free.
  void publish(const ForceSample& sample);

  /// Any thread: the newest sample, whole. Lock-free; tick 0: none computed yet.
  ForceSample latest() const;

 private:
  LatestWords<48> words_;
};

}  // namespace palpate
