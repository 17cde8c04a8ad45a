#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

/// Which of the grid times that a loop has missed are made good, by ticks that follow at once, and which are
/// skipped.
///
/// A stall (the core was taken, a page came from disk) leaves the loop some periods behind. Up to `limit` of them are
/// made good; those beyond are skipped, so that the loop is never further behind. Where the loop is still behind after
/// longest_spell * limit ticks in a row, it is no stall but overload: all that is owed is skipped, and nothing is made
/// good until a tick has again been in time. So a loop that can't keep its rate skips and sleeps between its ticks, as
/// without catching up, and does not take its core from others for good.
/// Real-time: no allocation, no lock, no throw. Test: realtime/timing/catch_up_test.cpp
class CatchUp {
 public:
  // A loop that computes for 3/4 of its time is back on the grid after four times the ticks that it was behind.
  static constexpr std::int64_t longest_spell = 4;

  /// @param limit  periods; 0: all are skipped
  explicit CatchUp(std::int64_t limit) : limit_(limit) {}

  struct Outcome {
    std::int64_t missed = 0;   // grid times that went by in this tick
    std::int64_t skipped = 0;  // grid times, of this tick or of those before, whose ticks will never be
  };

  /// A tick is done, `behind` grid times after its own have gone by.
  Outcome tickEnded(std::int64_t behind) {
    Outcome outcome;
    outcome.missed = behind - (owed_ > 0 ? owed_ - 1 : 0);  // one of those owed was this tick itself
    streak_ = behind > 0 ? streak_ + outcome.missed : 0;
    if (behind == 0) {
      paused();
      return outcome;
    }
    if (++spell_ > longest_spell * limit_) given_up_ = true;
    owed_ = given_up_ ? 0 : std::min(behind, limit_);
    outcome.skipped = behind - owed_;
    return outcome;
  }

  /// The next tick's grid time has gone by: it is to follow at once.
  bool owes() const { return owed_ > 0; }

  /// Grid times missed since a tick was last in time.
  std::int64_t streak() const { return streak_; }

  /// Nothing is owed after a pause.
  void paused() {
    owed_ = spell_ = streak_ = 0;
    given_up_ = false;
  }

 private:
  const std::int64_t limit_;
  std::int64_t owed_ = 0;   // ticks that are to follow at once
  std::int64_t spell_ = 0;  // ticks since one was in time
  std::int64_t streak_ = 0;
  bool given_up_ = false;  // overload
};

}  // namespace palpate
