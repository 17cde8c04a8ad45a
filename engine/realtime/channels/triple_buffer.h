#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace palpate {

/// Hands the newest value from one writer thread to one reader thread. Wait-free on
/// both sides: three slots, of which the writer owns one, the reader one, and the
/// third changes hands by one atomic exchange. A slow reader misses values, never
/// delays the writer, and never sees half of one.
template <class T>
class TripleBuffer {
 public:
  /// All slots start as copies of `initial`, so that T's memory is taken here.
  explicit TripleBuffer(const T& initial) : slots_{initial, initial, initial} {}
  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  /// Writer: the slot to fill. Holds some older value, not the last one published.
  T& back() { return slots_[back_]; }

  /// Writer: makes back() the newest value; back() is another slot from here on.
  void publish() { back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex; }

  /// Reader: the newest value published. Stays valid and unchanged until the next call.
  const T& latest() {
    if (middle_.load(std::memory_order_relaxed) & kFresh) {
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    }
    return slots_[front_];
  }

  /// Reader: whether latest() would return something new.
  bool hasNews() const { return (middle_.load(std::memory_order_relaxed) & kFresh) != 0; }

 private:
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kFresh = 4;  // the middle slot was published and not yet read

  std::array<T, 3> slots_;
  alignas(64) std::uint32_t back_ = 0;  // writer's
  alignas(64) std::atomic<std::uint32_t> middle_{1};
  alignas(64) std::uint32_t front_ = 2;  // reader's
};

}  // namespace palpate
