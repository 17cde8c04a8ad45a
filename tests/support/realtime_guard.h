#pragma once

namespace palpate::test {

/// What a thread did that a real-time thread must not.
struct GuardCounts {
  int allocations = 0;  // malloc and relatives, operator new through them
  int frees = 0;
  int locks = 0;        // mutex, read-write lock, condition variable

  int total() const { return allocations + frees + locks; }
};

/// Counts the calling thread's allocations and locks from startGuard() to stopGuard().
/// The counting replaces malloc and pthread_mutex_lock of the whole test program, which
/// sanitizers do themselves: under them guardAvailable() is false and all counts are 0.
bool guardAvailable();
void startGuard();
GuardCounts stopGuard();

}  // namespace palpate::test
