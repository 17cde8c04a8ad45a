#pragma once

#include <string>
#include <vector>

#include "base/spin_team.h"

namespace palpate {

/// What was asked of the operating system for the loop's threads, and what came of
/// it: "done: ..." or "not done: <reason, and what would allow it>". For report.json.
struct RtSetup {
  std::string scheduling;       // SCHED_FIFO
  std::string memory_lock;      // mlockall
  std::string affinity;         // a core of its own for each physics thread
  std::string denormals;        // flush-to-zero, denormals-are-zero
  std::vector<int> thread_ids;  // the kernel's, member 0 (the loop's thread) first
  std::vector<int> cores;       // where each is pinned, and the others that were allowed; empty: none is pinned
};

/// Prepares the calling thread and the team's workers for fixed-rate work: SCHED_FIFO,
/// memory lock, core affinity (member 0 on the last allowed core, the others below it; only
/// with SCHED_FIFO, because without it a pinned thread can't leave a busy core), timer slack,
/// flush-to-zero. What the system refuses is left out and said to be.
/// @param real_time  false (as fast as possible): only flush-to-zero, so that a busy
///                   loop doesn't hold cores against the rest of the machine
RtSetup setUpLoopThread(SpinTeam* team, bool real_time);

/// The team's workers become ordinary threads again, on the cores that the calling thread may use: for who goes on with
/// the team after its loop has ended.
void endRealTime(SpinTeam& team);

/// While nobody needs the rate: the threads that were set up for it become ordinary ones, on all cores; or have again
/// what they had. From any thread of the process. Does nothing where real-time priority was not granted.
void giveWay(const RtSetup& setup, bool yes);

/// Makes the calling (drawing) thread give way to the loop: nice level 10. Threads that
/// it starts later inherit that. Returns "done: ..." or "not done: <reason>".
std::string setUpViewerThread();

/// Denormal results and operands count as zero on the calling thread from here on.
void flushDenormals();

/// The same while it lives; then what the thread had before.
class FlushedDenormals {
 public:
  FlushedDenormals();
  ~FlushedDenormals();
  FlushedDenormals(const FlushedDenormals&) = delete;
  FlushedDenormals& operator=(const FlushedDenormals&) = delete;

 private:
  unsigned before_ = 0;
};

}  // namespace palpate
