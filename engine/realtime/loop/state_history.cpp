#include "realtime/loop/state_history.h"

#include <algorithm>
#include <cmath>

#include "setup/place.h"

namespace palpate {
namespace {

template <class T>
std::size_t bytesOf(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

std::size_t bytesOf(const ContactState& c) {
  const FaceSamples& s = c.samples;
  return bytesOf(c.vertex) + bytesOf(c.force) + bytesOf(c.normal) + bytesOf(c.side) + bytesOf(s.id) + bytesOf(s.force) +
         bytesOf(s.normal) + bytesOf(s.side) + bytesOf(s.point) + bytesOf(s.area) + bytesOf(s.lift);
}

/// Of the vectors that make up nearly all of a state.
std::size_t bytesOf(const State& s) {
  std::size_t bytes = sizeof(State) + 3 * s.u.capacity() * sizeof(Float4) + s.relaxation.Z.capacity() * sizeof(float) +
                      s.skins.vertex.size() * (2 * sizeof(int) + sizeof(float) + sizeof(Float4)) +
                      s.rigid.force.size() * sizeof(Float4) + bytesOf(s.rigid.normal) + bytesOf(s.rigid.row) +
                      bytesOf(s.rigid.near) + s.rigid.near_u.size() * sizeof(Float4);
  for (const ContactState& contact : s.contact) bytes += bytesOf(contact);
  return bytes;
}

}  // namespace

void StateHistory::Ring::keep(const State& state) {
  newest = (newest + 1) % slots.size();
  used = std::min(used + 1, slots.size());
  slots[newest] = state;  // no larger than there is room for: no allocation
  due = state.tick + every;
}

const State& StateHistory::Ring::at(std::size_t age) const {
  return slots[(newest + slots.size() - age) % slots.size()];
}

bool StateHistory::Ring::has(const PlaceIndex& place) const {
  for (std::size_t age = 0; age < used; ++age)
    if (at(age).place == place) return true;
  return false;
}

void StateHistory::Ring::dropAfter(std::int64_t tick) {
  for (; used > 0 && at(0).tick > tick; --used) newest = (newest + slots.size() - 1) % slots.size();
  due = used > 0 ? at(0).tick + every : tick + every;
}

void StateHistory::Ring::forget(const PlaceIndex& place) {
  for (std::size_t age = 0; age < used; ++age)
    if (at(age).place == place) used = age;
}

StateHistory::StateHistory(const State& start, double rate_hz, bool undo) : start_(start) {
  const std::size_t fitting = std::clamp<std::size_t>(max_past_bytes / bytesOf(start), 2, past_count);
  good_.slots.assign(2, start);
  if (undo) past_.slots.assign(fitting, start);
  reserveAs(start, start_);
  for (Ring* ring : {&good_, &past_})
    for (State& slot : ring->slots) reserveAs(start, slot);
  good_.every = std::max<std::int64_t>(1, std::llround(good_seconds * rate_hz));
  past_.every = std::max<std::int64_t>(1, std::llround(past_seconds * rate_hz));
}

bool StateHistory::keep(const State& state, Doubt doubt) {
  const bool good = doubt <= Doubt::Resolution && state.tick >= good_.due;  // never two copies in one tick
  const bool past = !good && !past_.slots.empty() && doubt < Doubt::Inverted && state.tick >= past_.due;
  if (good) good_.keep(state);
  if (past) past_.keep(state);
  return good || past;
}

const State& StateHistory::good(int age) const {
  const auto wanted = static_cast<std::size_t>(age);
  return wanted < good_.used ? good_.at(wanted) : start_;
}

const State* StateHistory::before(std::int64_t tick) const {
  for (std::size_t age = 0; age < past_.used; ++age)
    if (past_.at(age).tick <= tick - past_.every / 2) return &past_.at(age);
  return nullptr;
}

void StateHistory::wentBackTo(std::int64_t tick) {
  good_.dropAfter(tick);
  past_.dropAfter(tick);
}

void StateHistory::forget(const PlaceIndex& place) {
  good_.forget(place);
  past_.forget(place);
}

void StateHistory::clear() {
  good_.used = past_.used = 0;
  good_.due = past_.due = 0;
}

void StateHistory::startAt(const State& state) {
  start_ = state;  // no larger than there is room for: no allocation
  clear();
  good_.due = past_.due = state.tick;
}

std::size_t StateHistory::bytes() const { return (1 + good_.slots.size() + past_.slots.size()) * bytesOf(start_); }

}  // namespace palpate
