#include "realtime/loop/state_history.h"

#include <catch2/catch.hpp>

#include "realtime/fakes.h"
#include "support/realtime_guard.h"

using namespace palpate;

namespace {

State stateAt(std::int64_t tick) {
  State state;
  state.tick = tick;
  state.u.assign(10, Float4{static_cast<float>(tick), 0, 0, 0});
  state.du = state.u_low = state.u;
  return state;
}

}  // namespace

TEST_CASE("The last two undoubted states are kept, 50 ms apart, and none that is doubted", "[state_history]") {
  StateHistory history(stateAt(0), 500);
  CHECK(history.good(0).tick == 0);
  for (int tick = 1; tick <= 100; ++tick) history.keep(stateAt(tick), Doubt::None);
  CHECK(history.good(0).tick == 76);  // 1, 26, 51, 76
  CHECK(history.good(0).u[3].x == 76);
  CHECK(history.good(1).tick == 51);
  CHECK(history.good(2).tick == 0);  // the start
  for (int tick = 101; tick <= 300; ++tick) history.keep(stateAt(tick), Doubt::Step);
  CHECK(history.good(0).tick == 76);
  history.wentBackTo(51);
  CHECK(history.good(0).tick == 51);
  CHECK(history.good(1).tick == 0);
  for (int tick = 52; tick <= 77; ++tick) history.keep(stateAt(tick), Doubt::None);
  CHECK(history.good(0).tick == 76);
}

TEST_CASE("Undoing goes back half a second at a time, as far as states are kept", "[state_history]") {
  StateHistory history(stateAt(0), 500);
  CHECK(history.before(0) == nullptr);
  std::int64_t tick = 0;
  while (tick < 10'000) {
    ++tick;
    history.keep(stateAt(tick), tick % 3 == 0 ? Doubt::None : Doubt::Volume);
  }
  int steps = 0;
  for (const State* past = history.before(tick); past != nullptr; past = history.before(tick), ++steps) {
    CHECK(tick - past->tick >= 125);
    CHECK(tick - past->tick <= 125 + 252);
    CHECK(past->u[0].x == static_cast<float>(past->tick));
    history.wentBackTo(tick = past->tick);
  }
  CHECK(steps >= 19);
  CHECK(tick >= 10'000 - 20 * 253);  // ten seconds
  // What follows is kept anew.
  for (int k = 0; k < 600; ++k) history.keep(stateAt(++tick), Doubt::None);
  CHECK(history.before(tick) != nullptr);
  history.clear();
  CHECK(history.before(tick) == nullptr);
  CHECK(history.good(0).tick == 0);
}

TEST_CASE("A lost state is never kept, and nothing is allocated", "[state_history]") {
  StateHistory history(stateAt(0), 500);
  const State lost = stateAt(400), good = stateAt(401);
  test::startGuard();
  history.keep(lost, Doubt::Lost);
  history.keep(lost, Doubt::Inverted);
  const bool none = history.before(1000) == nullptr;
  history.keep(good, Doubt::None);
  history.keep(good, Doubt::None);
  const test::GuardCounts counts = test::stopGuard();
  CHECK(none);
  CHECK(history.before(1000) != nullptr);
  if (test::guardAvailable()) CHECK(counts.total() == 0);
}

TEST_CASE("The memory of the past is bounded", "[state_history]") {
  State large;
  large.u.assign(400'000, Float4{});  // 19 MB a state
  large.du = large.u_low = large.u;
  const StateHistory history(large, 500);
  const std::size_t one = 3 * large.u.size() * sizeof(Float4);
  CHECK(history.bytes() < 3 * (one + 1000) + StateHistory::max_past_bytes);
  CHECK(history.bytes() > 5 * one);
}
