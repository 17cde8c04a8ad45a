#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace palpate {

/// The newest value, as words, from one writer to any number of readers on threads of their own. Four slots are
/// written in turn: where the writer loses its core in the middle of one, readers still read the slot before. A reader
/// whose slot was overwritten while it read, which takes three writes, reads again. It accepts only the value that
/// newest_ announced, so no reader sees time go backwards.
/// The order of the stores makes a torn read visible: a reader that has seen any new word of a slot (acquire) is
/// synchronised with that word's store (release), and so sees the odd version that was stored before it.
template <std::size_t count>
class LatestWords {
 public:
  using Words = std::array<std::uint64_t, count>;

  /// Writer. Real-time: no allocation, no lock, wait-free.
  void publish(const Words& words) {
    const std::uint64_t next = newest_.load(std::memory_order_relaxed) + 1;
    Slot& slot = slots_[next % kSlots];
    slot.version.store(2 * next - 1, std::memory_order_relaxed);
    for (std::size_t w = 0; w < count; ++w) slot.words[w].store(words[w], std::memory_order_release);
    slot.version.store(2 * next, std::memory_order_release);
    newest_.store(next, std::memory_order_release);
  }

  /// Any thread: the newest value, whole. Lock-free. @pre something was published
  Words latest() const {
    Words words{};
    for (;;) {
      const std::uint64_t newest = newest_.load(std::memory_order_acquire);
      const Slot& slot = slots_[newest % kSlots];
      for (std::size_t w = 0; w < count; ++w) words[w] = slot.words[w].load(std::memory_order_acquire);
      // Any other version means that the slot has been reused, whole or in part, since newest_ was read.
      if (slot.version.load(std::memory_order_relaxed) == 2 * newest) return words;
    }
  }

 private:
  static constexpr std::size_t kSlots = 4;
  struct Slot {
    std::atomic<std::uint64_t> version{0};  // 2 n for the n-th value; odd while it is written
    std::array<std::atomic<std::uint64_t>, count> words{};
  };

  alignas(64) std::array<Slot, kSlots> slots_;
  alignas(64) std::atomic<std::uint64_t> newest_{0};  // n of the newest value, in slot n % kSlots
};

}  // namespace palpate
