#pragma once

#include <array>
#include <atomic>
#include <cstdint>

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

/// The newest force, from the loop to any number of readers (haptic device, viewer) on threads of
/// their own. Four slots are written in turn: where the writer loses its core in the middle of one,
/// readers still read the slot before. A reader whose slot was overwritten while it read, which takes
/// three ticks, reads again. It accepts only the sample that newest_ announced, so no reader sees time
/// go backwards.
class ForceOutput {
 public:
  ForceOutput() { publish({}); }

  /// Writer. Real-time: no allocation, no lock, wait-free.
  void publish(const ForceSample& sample);

  /// Any thread: the newest sample, whole. Lock-free; tick 0: none computed yet.
  ForceSample latest() const;

 private:
  static constexpr std::size_t kWords = 12;
  static constexpr std::size_t kSlots = 4;
  struct Slot {
    std::atomic<std::uint64_t> version{0};  // 2 n for the n-th sample; odd while it is written
    std::array<std::atomic<std::uint64_t>, kWords> words{};
  };

  alignas(64) std::array<Slot, kSlots> slots_;
  alignas(64) std::atomic<std::uint64_t> newest_{0};  // n of the newest sample, in slot n % kSlots
};

}  // namespace palpate
