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

/// A terminal that is closed sends SIGHUP more than once: by the kernel and by its shell.
void onHangUp(int) { asked = 1; }

}  // namespace

void catchInterrupts() {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is one that can't be written, and said to be
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  if (std::signal(SIGHUP, onHangUp) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // as nohup wants it
}

bool interrupted() { return asked != 0; }

}  // namespace palpate
