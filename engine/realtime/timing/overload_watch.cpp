#include "realtime/timing/overload_watch.h"

namespace palpate {
namespace {

constexpr auto kQuiet = static_cast<std::int64_t>(1e9 * OverloadWatch::quiet_seconds);
constexpr auto kBetweenLines = static_cast<std::int64_t>(1e9 * OverloadWatch::line_seconds);

}  // namespace

bool OverloadWatch::lineIsDue(std::int64_t now) const { return !any_line_ || now - last_line_ >= kBetweenLines; }

void OverloadWatch::logEvent(LogEvent::Kind kind, std::int64_t tick, LogRing& log) {
  LogEvent event;
  event.kind = kind;
  event.tick = tick;
  event.time_s = static_cast<double>(tick) / rate_hz_;
  event.overload = overload_;
  log.push(event);
  told_ticks_ = overload_.late_ticks;
}

void OverloadWatch::add(const LateTick& tick, std::int64_t now, LogRing& log) {
  const bool begins = !open_;
  if (begins) {
    open_ = true;
    overload_ = {};
    told_ticks_ = 0;
    first_late_ = now;
    first_told_ = lineIsDue(now);
  }
  overload_.add(tick);
  last_late_ = now;
  overload_.seconds = 1e-9 * static_cast<double>(now - first_late_);
  if (!begins || !first_told_) return;
  logEvent(LogEvent::Kind::TickLate, tick.tick, log);
  any_line_ = true;
  last_line_ = now;
}

void OverloadWatch::update(std::int64_t now, std::int64_t tick, LogRing& log) {
  if (!open_) return;
  const bool over = now - last_late_ >= kQuiet && (first_told_ || lineIsDue(now));
  if (!over && !lineIsDue(now)) return;
  if (overload_.late_ticks > told_ticks_) {
    logEvent(over ? LogEvent::Kind::OverloadEnded : LogEvent::Kind::Overloaded, tick, log);
    any_line_ = true;
    last_line_ = now;
  }
  if (over) open_ = false;
}

void OverloadWatch::end(std::int64_t tick, LogRing& log) {
  if (open_ && overload_.late_ticks > told_ticks_) logEvent(LogEvent::Kind::Overloaded, tick, log);
  open_ = false;
}

}  // namespace palpate
