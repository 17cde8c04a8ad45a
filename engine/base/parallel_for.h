#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

namespace palpate {

/// As many threads as are asked for; 0: one per core.
inline int threadsOr(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Threads of parallelFor; 0: one per core. Results never depend on it: tests set it to show that.
inline std::atomic<int> setup_threads{0};

/// While it lives, those of this thread's parallelFor: of work that must leave cores to others.
class OwnSetupThreads {
 public:
  explicit OwnSetupThreads(int threads) : before_(std::exchange(count_, threads)) {}
  ~OwnSetupThreads() { count_ = before_; }
  OwnSetupThreads(const OwnSetupThreads&) = delete;
  OwnSetupThreads& operator=(const OwnSetupThreads&) = delete;

  static int wanted() { return count_ > 0 ? count_ : setup_threads.load(); }

 private:
  static inline thread_local int count_ = 0;
  int before_;
};

/// While it lives, each parallelFor of this thread calls `look` before its parts, many times a second. It may throw,
/// which ends that parallelFor once the parts under way are done, and so the set-up that it is part of.
class SetupWatch {
 public:
  explicit SetupWatch(std::function<void()> look) : look_(std::move(look)), before_(std::exchange(current, this)) {}
  ~SetupWatch() { current = before_; }
  SetupWatch(const SetupWatch&) = delete;
  SetupWatch& operator=(const SetupWatch&) = delete;

  static void check() {
    if (current) current->look_();
  }

 private:
  static inline thread_local SetupWatch* current = nullptr;
  std::function<void()> look_;
  SetupWatch* before_;
};

/// Runs body(begin, end) over [0, count) in contiguous parts on all cores, a few parts per core, so that a
/// core that is slow or taken delays the others little. What body writes must not depend on where the parts end.
/// Set-up only. An exception of a part is rethrown here; of several, that of the lowest part, so that the
/// message does not depend on timing.
/// @param least  indices that are worth a part of their own
template <class Body>
void parallelFor(int count, Body&& body, int least = 64) {
  const int cores = threadsOr(OwnSetupThreads::wanted());
  constexpr int parts_per_core = 8;
  const int parts = std::clamp(count / least, 1, cores * parts_per_core);
  const int threads = std::min(cores, parts);
  std::vector<std::exception_ptr> errors(parts);
  std::exception_ptr ended;  // by the watch
  std::atomic<int> next{0};
  const auto work = [&](bool watched) {
    for (;;) {
      try {
        if (watched) SetupWatch::check();
      } catch (...) {
        ended = std::current_exception();
        next = parts;
      }
      const int p = next++;
      if (p >= parts) return;
      try {
        body(static_cast<int>(static_cast<long long>(count) * p / parts),
             static_cast<int>(static_cast<long long>(count) * (p + 1) / parts));
      } catch (...) {
        errors[p] = std::current_exception();
      }
    }
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work, false);
  work(true);
  for (auto& t : others) t.join();
  if (ended) std::rethrow_exception(ended);
  for (auto& e : errors)
    if (e) std::rethrow_exception(e);
}

}  // namespace palpate
