#pragma once

#include <vector>

#include "base/spin_team.h"
#include "support/realtime_guard.h"

namespace palpate::test {

// The guard counts for one thread; these set it on each member of a team, the owner (the caller) included.
// A worker's sleep is not counted: between ticks it waits on a futex, by a system call and without a lock.

inline void startGuard(SpinTeam& team) {
  team.run([](void*, int, int) { startGuard(); }, nullptr);
}

/// @param counts  what each member did since startGuard(team)   (member_count)
inline void stopGuard(SpinTeam& team, std::vector<GuardCounts>& counts) {
  team.run([](void* all, int member,
              int) { (*static_cast<std::vector<GuardCounts>*>(all))[static_cast<std::size_t>(member)] = stopGuard(); },
           &counts);
}

}  // namespace palpate::test
