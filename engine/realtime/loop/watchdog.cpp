#include "realtime/loop/watchdog.h"

#include <algorithm>
#include <cmath>

#include "step/trust.h"

namespace palpate {
namespace {

// A condition must have been absent for so long before it is logged again.
constexpr double kQuietSeconds = 1.0;

// Three losses within this time are restored from; a fourth freezes.
constexpr double kLossSeconds = 1.0;

Vec3 placeOf(const std::vector<Vec3>& X, int index) {
  const bool known = index >= 0 && index < static_cast<int>(X.size());
  return known ? X[static_cast<std::size_t>(index)] : Vec3::Zero();
}

}  // namespace

Watchdog::Watchdog(const Model& model) : model_(&model) { reset(); }

void Watchdog::reset() {
  recent_losses_ = 0;
  losses_.fill(kNever);
  last_seen_.fill(kNever);
}

bool Watchdog::begins(int warning, bool condition, std::int64_t tick) {
  if (!condition) return false;
  std::int64_t& last = last_seen_[static_cast<std::size_t>(warning)];
  const bool news = last == kNever || static_cast<double>(tick - last) > kQuietSeconds * model_->scene.dynamics.rate_hz;
  last = tick;
  return news;
}

Verdict Watchdog::lost(std::int64_t tick) {
  const auto is_recent = [&](std::int64_t loss) {
    return loss != kNever && static_cast<double>(tick - loss) <= kLossSeconds * model_->scene.dynamics.rate_hz;
  };
  recent_losses_ = static_cast<int>(std::count_if(losses_.begin(), losses_.end(), is_recent));
  if (recent_losses_ == static_cast<int>(losses_.size())) return Verdict::Freeze;
  losses_[next_loss_] = tick;
  next_loss_ = (next_loss_ + 1) % losses_.size();
  return Verdict::Restore;
}

Verdict Watchdog::judge(const StepReport& report, std::int64_t tick, LogRing& log) {
  const auto logEvent = [&](LogEvent::Kind kind, int index, const Vec3& position, double value) {
    LogEvent event;
    event.kind = kind;
    event.tick = tick;
    event.time_s = static_cast<double>(tick) / model_->scene.dynamics.rate_hz;
    event.index = index;
    event.position = position;
    event.value = value;
    log.push(event);
  };
  const Vec3 node_X = placeOf(model_->X, report.worst_node);
  const Vec3 point_X = placeOf(model_->point_X, report.worst_point);

  using Kind = LogEvent::Kind;
  const bool finite = std::all_of(report.loads.begin(), report.loads.end(),
                                  [](const ToolLoad& load) { return load.force.allFinite(); });
  if ((report.flags & kNotFinite) || !report.tool_force.allFinite() || !finite) {
    const Verdict verdict = lost(tick);
    logEvent(verdict == Verdict::Freeze ? Kind::FrozenNotFinite : Kind::RestoredNotFinite, report.worst_node, node_X,
             0);
    return verdict;
  }
  if (report.flags & kBlowUp) {
    const Verdict verdict = lost(tick);
    logEvent(verdict == Verdict::Freeze ? Kind::FrozenBlowUp : Kind::RestoredBlowUp, report.worst_node, node_X,
             report.max_increment);
    return verdict;
  }
  if (begins(0, report.inverted_points > 0, tick)) {
    logEvent(LogEvent::Kind::InvertedPoints, report.worst_point, point_X, report.inverted_points);
  }
  if (begins(1, report.flags & kContactOverflow, tick)) {
    logEvent(LogEvent::Kind::ContactOverflow, -1, Vec3::Zero(), 0);
  }
  if (begins(2, report.flags & kDeepContact, tick)) {
    const bool of_tool = report.max_penetration > TrustLimits::penetration * model_->scene.tools[0].shape.radius;
    if (of_tool)
      logEvent(Kind::DeepContact, -1, Vec3::Zero(), report.max_penetration);
    else
      logEvent(Kind::Doubted, static_cast<int>(Doubt::Contact), Vec3::Zero(), 0);
  }
  // The doubts that none of the events above tells of.
  const Doubt doubt = doubtOf(*model_, report);
  const bool other =
      doubt == Doubt::Volume || doubt == Doubt::Squeezed || doubt == Doubt::Step || doubt == Doubt::Energy;
  if (begins(3, other, tick)) logEvent(LogEvent::Kind::Doubted, static_cast<int>(doubt), Vec3::Zero(), 0);
  return Verdict::Good;
}

}  // namespace palpate
