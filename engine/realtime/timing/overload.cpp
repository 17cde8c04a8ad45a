#include "realtime/timing/overload.h"

#include "base/number_text.h"

namespace palpate {
namespace {

constexpr std::array<const char*, kLateCauseCount> kCauseNames = {"woken late", "core taken", "worker late",
                                                                  "long computation"};

double ms(std::int64_t ns) { return 1e-6 * static_cast<double>(ns); }

/// "7 periods late, 3 skipped": of all that were missed, those that are not made good.
std::string periodsText(std::int64_t missed, std::int64_t skipped) {
  const char* s = missed == 1 ? "" : "s";
  if (skipped >= missed) return format("%lld period%s skipped", asLongLong(skipped), skipped == 1 ? "" : "s");
  if (skipped == 0) return format("%lld period%s late, made good", asLongLong(missed), s);
  return format("%lld period%s late, %lld skipped", asLongLong(missed), s, asLongLong(skipped));
}

}  // namespace

LateCause causeOf(const LateTick& tick) {
  // The cause is what alone would have had to be different for the tick to be in time. A wake-up counts as late
  // from a quarter of the period on: each is some microseconds late, which a long tick must not be blamed on.
  const bool woken_late = 4 * tick.late_ns >= tick.period_ns;
  if (woken_late && (tick.step_ns <= tick.period_ns || tick.late_ns >= tick.step_ns)) return LateCause::LateWakeUp;
  if (tick.late_ns + tick.computing_ns > tick.period_ns) return LateCause::LongComputation;
  return tick.long_waits > 0 ? LateCause::WorkerLate : LateCause::CoreTaken;
}

void Overload::add(const LateTick& tick) {
  if (late_ticks == 0) first_tick = tick.tick;
  ++late_ticks;
  missed += tick.missed;
  skipped += tick.skipped;
  ++by_cause[static_cast<std::size_t>(causeOf(tick))];
  if (tick.missed > worst.missed) worst = tick;
}

std::string lateTickText(const LateTick& t) {
  std::string text = format("tick %lld ", asLongLong(t.tick));
  switch (causeOf(t)) {
    case LateCause::LateWakeUp:
      text += format("was woken %.1f ms late: its core was taken or the process stopped", ms(t.late_ns));
      break;
    case LateCause::CoreTaken:
      text += format("took %.1f ms, %.1f of them computing: its core was taken or the process stopped", ms(t.step_ns),
                     ms(t.computing_ns));
      break;
    case LateCause::WorkerLate:
      text += format("took %.1f ms, %.1f of them computing: it waited for a worker thread, whose core was taken",
                     ms(t.step_ns), ms(t.computing_ns));
      break;
    case LateCause::LongComputation:
      text += format(
          "computed for %.1f ms of a period of %.1f ms: long computation, or a core slowed by its "
          "neighbour or host",
          ms(t.computing_ns), ms(t.period_ns));
      break;
  }
  return text +
         format(" (%lld involuntary switches, %lld page faults); ", asLongLong(t.involuntary_switches),
                asLongLong(t.page_faults)) +
         periodsText(t.missed, t.skipped);
}

std::string overloadText(const Overload& overload) {
  std::string causes;
  for (std::size_t c = 0; c < kLateCauseCount; ++c) {
    if (overload.by_cause[c] == 0) continue;
    causes += format("%s%lld %s", causes.empty() ? "" : ", ", asLongLong(overload.by_cause[c]), kCauseNames[c]);
  }
  return format("%lld late tick%s in %.1f s (", asLongLong(overload.late_ticks), overload.late_ticks == 1 ? "" : "s",
                overload.seconds) +
         causes + "), " + periodsText(overload.missed, overload.skipped) +
         "; the worst: " + lateTickText(overload.worst);
}

}  // namespace palpate
