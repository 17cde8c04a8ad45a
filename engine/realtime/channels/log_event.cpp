#include "realtime/channels/log_event.h"

#include <cmath>

#include "base/number_text.h"
#include "step/trust.h"

namespace palpate {
namespace {

/// "3 integration points are", "1 integration point is".
std::string pointsAre(double count) { return format("%.0f integration point%s", count, count == 1 ? " is" : "s are"); }

std::string sentence(const LogEvent& e) {
  const Vec3& p = e.position;
  switch (e.kind) {
    case LogEvent::Kind::FrozenNotFinite:
      return format(
          "frozen: the displacement of node %d at (%.4f, %.4f, %.4f) m is not a number; "
          "reset to go on, lower dynamics.time_step or step_safety if it comes again",
          e.index, p.x(), p.y(), p.z());
    case LogEvent::Kind::FrozenBlowUp:
      return format(
          "frozen: node %d at (%.4f, %.4f, %.4f) m moved %.3g mm in one step; "
          "reset to go on, lower dynamics.time_step or step_safety if it comes again",
          e.index, p.x(), p.y(), p.z(), 1e3 * e.value);
    case LogEvent::Kind::RestoredNotFinite:
      return format(
          "restored: the displacement of node %d at (%.4f, %.4f, %.4f) m was not a number; the tissue is back where "
          "it was shortly before, at rest",
          e.index, p.x(), p.y(), p.z());
    case LogEvent::Kind::RestoredBlowUp:
      return format(
          "restored: node %d at (%.4f, %.4f, %.4f) m moved %.3g mm in one step; the tissue is back where it was "
          "shortly before, at rest",
          e.index, p.x(), p.y(), p.z(), 1e3 * e.value);
    case LogEvent::Kind::RestoredFolded:
      return format(
          "restored: nothing touches the tissue, and yet it stayed folded, a point of it at %.0f %% of its volume; it "
          "is "
          "put back to rest",
          100 * e.value);
    case LogEvent::Kind::InvertedPoints:
      return format(
          "%s inverted, the worst, %d, at (%.4f, %.4f, %.4f) m; "
          "results there are not to be trusted",
          pointsAre(e.value).c_str(), e.index, p.x(), p.y(), p.z());
    case LogEvent::Kind::ContactOverflow:
      return "more skin touches, tools or itself, than the contact lists can hold: part of the contact is ignored; "
             "smaller tools touch less, and what is pressed together less touches less of itself";
    case LogEvent::Kind::DeepContact:
      return format("the tool is %.3g mm deep in the skin: the contact is not to be trusted; press less hard",
                    1e3 * e.value);
    case LogEvent::Kind::Doubted:
      return format("the force is not to be trusted: %s", doubtText(static_cast<Doubt>(e.index)));
    case LogEvent::Kind::TickLate:
      return "overload: " + lateTickText(e.overload.worst);
    case LogEvent::Kind::Overloaded:
      return "overload: " + overloadText(e.overload);
    case LogEvent::Kind::OverloadEnded:
      return "on time again after " + overloadText(e.overload);
    case LogEvent::Kind::ToolYields:
      if (e.index == 1) return format("the tool stands before what is rigid, %.3g mm from the hand", 1e3 * e.value);
      return format(
          "the tool yields: the tissue can take no more, or its hand pushes no harder (max_force); it stays %.3g mm "
          "behind the hand",
          1e3 * e.value);
    case LogEvent::Kind::ToolLetsGo:
      return format(
          "tool %d was stuck in the tissue, far from its hand: it lets go, and touches nothing until it is out",
          e.index + 1);
    case LogEvent::Kind::Reset:
      return "reset";
    case LogEvent::Kind::Undone:
      // What is kept lies half a second apart, and so is what a user is told.
      return e.value > 0 ? format("undone: %.1f s back", 0.5 * std::round(2 * e.value))
                         : std::string("nothing to undo: no state is kept");
    case LogEvent::Kind::Paused:
      return "paused";
    case LogEvent::Kind::Resumed:
      return "resumed";
    case LogEvent::Kind::FrictionSet:
      return (e.index > 0 ? format("friction of tool %d", e.index + 1) : "friction") + format(" is now %.3g", e.value);
    case LogEvent::Kind::MaterialSet:
      return format("material %d changed", e.index);
    case LogEvent::Kind::MaterialRefused:
      return format(
          "material %d is %.3g times too stiff for the time step: not changed; "
          "set it in the scene and load again",
          e.index, e.value);
    case LogEvent::Kind::GravitySet:
      return e.value > 0
                 ? format("gravity is now (%.3g, %.3g, %.3g) m/s^2", e.position.x(), e.position.y(), e.position.z())
                 : std::string("gravity is the scene's again");
    case LogEvent::Kind::ForceSet:
      if (e.index < 0) return "no force acts on the skin any more";
      return e.value > 0 ? format("a force acts on skin vertex %d", e.index)
                         : format("no force acts on skin vertex %d any more", e.index);
    case LogEvent::Kind::Pinned:
      if (e.index < 0) return "no skin vertex is pinned any more";
      return format(e.value > 0 ? "skin vertex %d is pinned" : "skin vertex %d is no longer pinned", e.index);
    case LogEvent::Kind::RegionMoved:
      if (e.index < 0) return "no region is moved any more";
      return format(e.value > 0 ? "region %d is moved" : "region %d is no longer moved", e.index);
    case LogEvent::Kind::TrackEnded:
      return "the tool has gone all of its way";
    case LogEvent::Kind::Marked:
      return "marked";
    case LogEvent::Kind::Unmarked:
      return "the last mark is taken back";
    case LogEvent::Kind::Submitted:
      return "the answers are in";
  }
  return "unknown event";
}

}  // namespace

/// What the hand can do; what the scene's author can is in the log.
static const char* adviceToHand(Doubt doubt) {
  switch (doubt) {
    case Doubt::Step:
      return "press slower";
    case Doubt::Energy:
    case Doubt::Lost:
      return "reset";
    default:
      return "press less";
  }
}

std::string briefText(const LogEvent& event) {
  const Overload& o = event.overload;
  const std::string late = format("%lld late tick%s in %.1f s", static_cast<long long>(o.late_ticks),
                                  o.late_ticks == 1 ? "" : "s", o.seconds);
  switch (event.kind) {
    case LogEvent::Kind::TickLate:
      return "the computer is late: see Timing";
    case LogEvent::Kind::Overloaded:
      return "the computer is too slow: " + late;
    case LogEvent::Kind::OverloadEnded:
      return "on time again after " + late;
    case LogEvent::Kind::Doubted: {
      const std::string cause = sentence(event);
      return cause.substr(0, cause.rfind(": ") + 2) + adviceToHand(static_cast<Doubt>(event.index));
    }
    default:
      return sentence(event);
  }
}

std::string logText(const LogEvent& event) { return format("%.3f s: ", event.time_s) + sentence(event); }

}  // namespace palpate
