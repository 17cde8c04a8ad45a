#pragma once

#include <functional>

namespace palpate::test {

/// What a thread did that a real-time thread must not.
struct GuardCounts {
  int allocations = 0;  // malloc and relatives, operator new through them
  int frees = 0;
  int locks = 0;  // mutex, read-write lock, condition variable

  int total() const { return allocations + frees + locks; }
};

/// Counts the calling thread's allocations and locks from startGuard() to stopGuard().
/// The counting replaces malloc and pthread_mutex_lock of the whole test program, which
/// sanitizers do themselves: under them guardAvailable() is false and all counts are 0.
bool guardAvailable();
void startGuard();
GuardCounts stopGuard();

/// From here on, any system call of this thread but sleeping, reading clocks and its own use of
/// the processor, and exiting ends the process
/// with exit code 100 + its number mod 100; kNoFilter where seccomp is not permitted.
/// For child processes.
constexpr int kNoFilter = 99;
void allowOnlySleeping();

/// Forks; the child ends with the code that `body` returns. -1: no child; -n: signal n.
int exitCodeOfChild(const std::function<int()>& body);

}  // namespace palpate::test
