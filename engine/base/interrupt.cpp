#include "base/interrupt.h"

#include <atomic>
#include <csignal>

namespace palpate {

namespace {

// Read by any thread; a lock-free atomic may be written by a signal handler.
std::atomic<int> asked = 0;
static_assert(std::atomic<int>::is_always_lock_free);

void onSignal(int signal) {
  asked = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void catchInterrupts() {
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
}

bool interrupted() { return asked != 0; }

}  // namespace palpate
