#pragma once

#include <cstddef>
#include <deque>

#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// Copies of the last minute's snapshots, to look back at while the loop waits. Belongs to the main thread.
class PastPictures {
 public:
  static constexpr double seconds = 60;                          // of the run, how far back they reach,
  static constexpr double apart = 0.2;                           // between two,
  static constexpr std::size_t most_bytes = 128u * 1024 * 1024;  // if so many fit

  /// Keeps a copy if it is time for one. A snapshot that is older than the last one begins anew.
  void add(const Snapshot& snapshot);

  bool empty() const { return kept_.empty(); }
  std::size_t size() const { return kept_.size(); }
  double begin_s() const { return kept_.empty() ? 0 : kept_.front().force.time_s; }

  /// The last that is not later than `time_s`, or the first; not while empty.
  const Snapshot& at(double time_s) const;

 private:
  std::deque<Snapshot> kept_;
  std::size_t bytes_ = 0;
};

}  // namespace palpate::app
