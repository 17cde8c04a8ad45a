#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/state.h"

namespace palpate {

/// Copies of a run's earlier states: the last two that nothing spoke against, to go back to when the tissue is lost,
/// and one for each half second, to undo with. What is kept depends on the ticks alone, so a replay finds the same.
/// Loop thread only. All memory is taken by the constructor: copies of whole states, bytes() in all.
/// Real-time: no allocation, no lock, no throw; a copy is small beside the 25 ticks or more between two.
class StateHistory {
 public:
  static constexpr double good_seconds = 0.05;                     // physics time between undoubted states
  static constexpr double past_seconds = 0.5;                      // between states to undo with
  static constexpr std::size_t past_count = 20;                    // the last ten seconds,
  static constexpr std::size_t max_past_bytes = 64 * 1024 * 1024;  // or as many of them as fit (at least two)

  /// @param start  freshly loaded
  /// @param undo   whether states to undo with are kept
  StateHistory(const State& start, double rate_hz, bool undo = true);

  /// A tick has ended well. Copies the state if it is time for that. @return whether it was
  bool keep(const State& state, Doubt doubt);

  /// The undoubted state that was kept last (age 0), the one before (1); the start where there is none.
  const State& good(int age) const;

  /// The newest state to undo with that is some time older than `tick`; null: none is kept.
  const State* before(std::int64_t tick) const;

  /// The physics is back at this tick: what was kept after it never was.
  void wentBackTo(std::int64_t tick);

  /// Whether a state of this place is kept.
  bool has(const PlaceIndex& place) const { return start_.place == place || good_.has(place) || past_.has(place); }

  /// States of this place, and all before them, can't be gone back to any more.
  void forget(const PlaceIndex& place);

  /// The physics was reset.
  void clear();

  /// The physics is at a state from elsewhere, which is the start from now on.
  void startAt(const State& state);

  std::size_t bytes() const;

 private:
  /// The newest `used` of its slots hold states, the newest in slot `newest`.
  struct Ring {
    std::vector<State> slots;
    std::int64_t every = 1;  // ticks
    std::int64_t due = 0;    // tick
    std::size_t newest = 0, used = 0;

    void keep(const State& state);
    const State& at(std::size_t age) const;
    bool has(const PlaceIndex& place) const;
    void dropAfter(std::int64_t tick);
    void forget(const PlaceIndex& place);
  };

  State start_;
  Ring good_, past_;
};

}  // namespace palpate
