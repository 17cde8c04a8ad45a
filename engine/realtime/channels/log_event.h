#pragma once

#include <cstdint>
#include <string>

#include "base/types.h"
#include "realtime/channels/spsc_ring.h"
#include "realtime/timing/overload.h"

namespace palpate {

/// Something that happened in the loop and that the user should read. Fixed size, so that
/// the real-time thread can pass it on; another thread makes the sentence with logText().
struct LogEvent {
  enum class Kind : std::uint8_t {
    FrozenNotFinite,    // node, position
    FrozenBlowUp,       // node, position; value: m, increment in one step
    RestoredNotFinite,  // the same, after which the tissue went back to an earlier state
    RestoredBlowUp,
    RestoredFolded,   // value: J of the worst point
    InvertedPoints,   // warning: point, position; value: how many
    ContactOverflow,  // warning
    DeepContact,      // warning: value: penetration, m
    Doubted,          // warning: index: the Doubt
    TickLate,         // warning: overload.worst
    Overloaded,       // warning: overload, which goes on
    OverloadEnded,    // overload
    ToolYields,       // warning: value: m, how far the tool is from the hand; index: 1 where what is rigid stops it
    ToolLetsGo,       // warning: index: tool
    Reset,            // index: 1 where a script or replay begins again with it
    Undone,           // value: s of physics time that the tissue went back; 0: nothing was kept to go back to
    Paused,
    Resumed,
    FrictionSet,      // index: tool, value
    MaterialSet,      // index: material
    MaterialRefused,  // index: material; value: factor by which it is too stiff
    GravitySet,       // position: m/s^2; value: 1, or 0 where it is the scene's again
    ForceSet,         // index: skin vertex, -1: all; value: 1 where a force begins to act, 0 where it ends
    Pinned,           // likewise
    RegionMoved,      // index: region, -1: all; value: 1, or 0 where it goes back to where the scene has it
    TrackEnded,       // script or replay is over
    Marked,           // position; index: how hard
    Unmarked,
    Submitted,  // index: 1 where a recording said so
  };
  Kind kind = Kind::Reset;
  std::int64_t tick = 0;         // of the run
  double time_s = 0;             // of the run
  int index = -1;                // node, integration point or material, as noted above
  Vec3 position = Vec3::Zero();  // m, reference configuration
  double value = 0;
  Overload overload;

  bool isFreeze() const { return kind <= Kind::FrozenBlowUp; }
  bool isRestore() const { return kind > Kind::FrozenBlowUp && kind <= Kind::RestoredFolded; }
  bool isWarning() const {
    return (kind > Kind::FrozenBlowUp && kind <= Kind::Overloaded) || kind == Kind::ToolYields ||
           kind == Kind::ToolLetsGo;
  }
};

using LogRing = SpscRing<LogEvent>;

/// "12.340 s: 12 integration points are inverted, the worst, 4711, at (0.0100, 0.0200, 0.0510) m;
/// results there are not to be trusted". Allocates: not for the loop thread.
std::string logText(const LogEvent& event);

/// The same without the time, and of an overload only what a user needs: how long the computer was late.
std::string briefText(const LogEvent& event);

}  // namespace palpate
