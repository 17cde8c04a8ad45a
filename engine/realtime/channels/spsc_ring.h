#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <vector>

namespace palpate {

/// A bounded queue from one producer thread to one consumer thread. Wait-free on
/// both sides; all memory is taken by the constructor. T is copied by assignment,
/// which must not allocate where a real-time thread pushes or pops.
template <class T>
class SpscRing {
 public:
  /// Holds at least `capacity` entries (rounded up to a power of two).
  explicit SpscRing(std::size_t capacity) : slots_(std::bit_ceil(capacity < 1 ? std::size_t{1} : capacity)) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  std::size_t capacity() const { return slots_.size(); }

  /// Producer: appends `value`; false and nothing done when full.
  bool push(const T& value) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - seen_head_ == slots_.size()) {
      seen_head_ = head_.load(std::memory_order_acquire);
      if (tail - seen_head_ == slots_.size()) return false;
    }
    slots_[tail & (slots_.size() - 1)] = value;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer: takes the oldest entry into `value`; false when empty.
  bool pop(T& value) {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == seen_tail_) {
      seen_tail_ = tail_.load(std::memory_order_acquire);
      if (head == seen_tail_) return false;
    }
    value = slots_[head & (slots_.size() - 1)];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Entries waiting. Exact on either of the two threads when the other rests.
  std::size_t size() const {
    const std::size_t head = head_.load(std::memory_order_acquire);
    return tail_.load(std::memory_order_acquire) - head;
  }

 private:
  std::vector<T> slots_;
  // Each side counts up and keeps its last view of the other's counter, so that the
  // cache line of the other changes hands only when the ring looks full or empty.
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::size_t seen_head_ = 0;
  alignas(64) std::atomic<std::size_t> head_{0};
  std::size_t seen_tail_ = 0;
};

}  // namespace palpate
