#include "realtime/channels/force_output.h"

#include <algorithm>
#include <bit>

namespace palpate {

double freshSeconds(double rate_hz) {
  constexpr double kHandSeconds = 0.010;  // longer: a device pushes against where the hand was
  constexpr double kPeriods = 3;          // below 2, an on-time loop reads as stale
  return std::max(kHandSeconds, kPeriods / rate_hz);
}

ForceReading readForce(const ForceSample& sample, std::int64_t now, double rate_hz) {
  ForceReading reading{sample, 1e-9 * static_cast<double>(std::max<std::int64_t>(0, now - sample.wall_ns)), false};
  reading.fresh = sample.tick > 0 && reading.age_s <= freshSeconds(rate_hz);
  return reading;
}

// The order of the stores makes a torn read visible: a reader that has seen any new word of a slot (acquire) is
// synchronised with that word's store (release), and so sees the odd version that was stored before it.
void ForceOutput::publish(const ForceSample& s) {
  const std::array<std::uint64_t, kWords> words = {
      std::bit_cast<std::uint64_t>(s.tick),
      std::bit_cast<std::uint64_t>(s.wall_ns),
      std::bit_cast<std::uint64_t>(s.time_s),
      std::bit_cast<std::uint64_t>(s.depth_m),
      std::bit_cast<std::uint64_t>(s.force_raw.x()),
      std::bit_cast<std::uint64_t>(s.force_raw.y()),
      std::bit_cast<std::uint64_t>(s.force_raw.z()),
      std::bit_cast<std::uint64_t>(s.force_filtered.x()),
      std::bit_cast<std::uint64_t>(s.force_filtered.y()),
      std::bit_cast<std::uint64_t>(s.force_filtered.z()),
      static_cast<std::uint64_t>(s.doubt),
      std::bit_cast<std::uint64_t>(s.advance_m),
  };
  const std::uint64_t next = newest_.load(std::memory_order_relaxed) + 1;
  Slot& slot = slots_[next % kSlots];
  slot.version.store(2 * next - 1, std::memory_order_relaxed);
  for (std::size_t w = 0; w < kWords; ++w) slot.words[w].store(words[w], std::memory_order_release);
  slot.version.store(2 * next, std::memory_order_release);
  newest_.store(next, std::memory_order_release);
}

ForceSample ForceOutput::latest() const {
  std::array<std::uint64_t, kWords> words{};
  for (;;) {
    const std::uint64_t newest = newest_.load(std::memory_order_acquire);
    const Slot& slot = slots_[newest % kSlots];
    for (std::size_t w = 0; w < kWords; ++w) words[w] = slot.words[w].load(std::memory_order_acquire);
    // Any other version means that the slot has been reused, whole or in part, since newest_ was read.
    if (slot.version.load(std::memory_order_relaxed) == 2 * newest) break;
  }
  const auto real = [&words](std::size_t w) { return std::bit_cast<double>(words[w]); };
  ForceSample s;
  s.tick = std::bit_cast<std::int64_t>(words[0]);
  s.wall_ns = std::bit_cast<std::int64_t>(words[1]);
  s.time_s = real(2);
  s.depth_m = real(3);
  s.force_raw = {real(4), real(5), real(6)};
  s.force_filtered = {real(7), real(8), real(9)};
  s.doubt = static_cast<Doubt>(words[10]);
  s.advance_m = real(11);
  return s;
}

}  // namespace palpate
