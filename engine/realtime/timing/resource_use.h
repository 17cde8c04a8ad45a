#pragma once

#include <cstdint>

namespace palpate {

/// What a thread of this process has gone through since it began. From /proc: not for the loop thread.
struct ThreadCounters {
  std::int64_t minor_faults = 0, major_faults = 0;  // pages mapped, pages read from disk
  std::int64_t voluntary_switches = 0, involuntary_switches = 0;

  ThreadCounters operator-(const ThreadCounters& before) const;
};

/// @param thread_id  the kernel's; a thread that has ended, or 0, gives zeros
ThreadCounters readThreadCounters(int thread_id);

/// Memory of this process, bytes. Exact (smaps_rollup), unlike the kernel's running totals, which each
/// thread brings up to date only now and then.
struct MemoryUse {
  std::int64_t resident = 0;   // with mapped files: code counts from when it first runs
  std::int64_t anonymous = 0;  // heap and stacks: what a leak grows
};

MemoryUse readMemoryUse();

}  // namespace palpate
