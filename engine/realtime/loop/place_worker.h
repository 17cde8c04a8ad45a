#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "realtime/channels/spsc_ring.h"
#include "realtime/channels/triple_buffer.h"
#include "realtime/loop/physics.h"

namespace palpate {

/// Makes the places that a loop's tool comes to (setup/place.h), on a thread of its own, while the loop goes on:
/// the loop says where it is and where to, and finds the change there once it is ready. Keeps the places that it made
/// last in memory (some 32 MB each, for a liver), and sees to it that those around are kept on disk, where any are.
/// What the loop's thread may call is real-time: no allocation, no lock, no throw.
class PlaceWorker {
 public:
  /// May take seconds; runs on the worker's thread alone. Equal results for equal indices.
  using Make = std::function<std::shared_ptr<const Place>(const PlaceIndex&)>;
  // In memory, those that the loop holds included, where it can: the start, the present one and the next, where a place
  // that was made once is read in a moment (0.15 s for a liver); where it would have to be made anew (0.4 s), the one
  // after, too, or the nearest around the present one.
  static constexpr std::size_t most_read = 3, most_made = 4;

  /// @param start    where the loop begins, with the team that steps all places
  /// @param threads  that a place is made with, and which give way to all others; 0: all cores, as good as any
  /// @param kept     what `make` made once it reads from then on
  PlaceWorker(const Places& places, Make make, std::shared_ptr<ReadyPlace> start, int threads = 1, bool kept = false);
  ~PlaceWorker();  // after what is being made is done
  PlaceWorker(const PlaceWorker&) = delete;
  PlaceWorker& operator=(const PlaceWorker&) = delete;

  struct Wish {
    PlaceIndex from = no_place, to = no_place;
    PlaceIndex then = no_place;  // a place that will be wanted after that, or no_place
    bool operator==(const Wish&) const = default;
  };
  /// Loop: the change that is wanted from now on. A change that is being made is made to its end.
  void want(const Wish& wish);

  /// Loop: the change that was made last, or null: none since the last call. The caller's until it gives it back.
  PlaceChange* take();
  void giveBack(PlaceChange* change) { returned_.push(change); }
  /// (any thread) From the next place on as with so many `threads`, for good: what has given way can't take it back.
  void giveWay(int threads) { threads_.store(threads, std::memory_order_relaxed); }
  /// (any thread) Whether take() would find one.
  bool isReady() const { return ready_.load(std::memory_order_acquire) != nullptr; }

  /// Loop: whether that place can't be made.
  bool failed(const PlaceIndex& index);
  /// (any thread) Why a place could not be made, the first; "": all could.
  std::string failure() const;

  /// (any thread) Places made so far, and the seconds that took.
  int madeCount() const { return made_count_.load(std::memory_order_relaxed); }
  double madeSeconds() const { return made_seconds_.load(std::memory_order_relaxed); }

 private:
  void work();
  void clear();
  std::shared_ptr<const Place> make(const PlaceIndex& index);
  std::shared_ptr<ReadyPlace> at(const PlaceIndex& index);
  PlaceIndex missingNeighbour(const PlaceIndex& index) const;
  void fail(const PlaceIndex& index, const std::string& why);

  const Places& places_;
  const Make make_;
  std::atomic<int> threads_;
  const bool kept_;
  const std::shared_ptr<ReadyPlace> start_;

  TripleBuffer<Wish> wishes_;
  Wish wanted_;  // the loop's
  std::atomic<std::uint32_t> wish_count_{0};
  std::atomic<bool> stop_{false};
  std::atomic<PlaceChange*> ready_{nullptr};
  SpscRing<PlaceChange*> returned_;
  TripleBuffer<PlaceIndex> failures_;  // the one that failed last
  mutable std::mutex failure_mutex_;   // never the loop's
  std::string failure_;
  std::atomic<int> made_count_{0};
  std::atomic<double> made_seconds_{0};

  // The worker's.
  struct Shelved {
    std::shared_ptr<ReadyPlace> place;
    std::uint64_t used = 0;
  };
  /// By others than the shelf: else nobody can get it.
  static bool isHeld(const Shelved& shelved) { return shelved.place.use_count() > 1; }
  std::size_t most() const { return kept_ ? most_read : most_made; }
  std::map<PlaceIndex, Shelved> shelf_;
  std::set<PlaceIndex> seen_;  // made or read once
  std::uint64_t uses_ = 0;
  std::thread thread_;
};

}  // namespace palpate
