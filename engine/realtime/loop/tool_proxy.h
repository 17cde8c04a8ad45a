#pragma once

#include <vector>

#include "model/model.h"
#include "model/state.h"
#include "realtime/loop/snag_watch.h"

namespace palpate {

/// Where the tool yields: beyond a doubt's limit (step/trust.h) its advance becomes slower, and here it ends.
/// Each is the last resort before the solution is lost, not where it becomes inexact.
struct YieldLimits {
  static constexpr double min_J = 0.1;        // from TrustLimits::min_J on
  static constexpr double penetration = 0.3;  // of the tool's radius, from TrustLimits::penetration on
  // Of the skin's edges beside the tool: what is drawn out so far has torn. Laws that don't stiffen let a ball push a
  // channel through the liver with 1 N, 90 mm long, and that closes over it. The deepest press that is trusted, three
  // radii into the liver, stretches by 2.1. The tool draws the skin no further from where it is at rest; back it is
  // free. Swept in engine/README.md.
  static constexpr double free_stretch = 2.5, stretch = 3.5;
  // Of sound in the softest tissue: a tool as fast as sound would crush what is before it, as the tissue behind knows
  // nothing of it yet (J = 1 - speed / sound, in one dimension).
  static constexpr double sound_share = 0.5;
};

/// The tool that the tissue feels: it follows the hand (mouse, device, script or recording), but yields where the
/// tissue can take no more, as a hand on a real tool would.
///
///   advance = g^2 (hand - tool), along the tool's axis and across it, each as far as it goes against the tissue's push
///   g = min over the limits of clamp((limit - value) / (limit - begin), 0, 1)
///
/// Where the skin beside it is drawn out it goes no further from where that is at rest (drawnWay).
/// To more than ToolSetUp::max_force it gives way within the step (ToolHold).
///
/// Where it is stuck in the tissue (SnagWatch) it lets go: it goes to the hand without touching tissue, which springs
/// back; once it is there and outside of the skin it touches again. What is rigid stops it all the while (RigidStop).
///
/// In tissue it advances at half the speed of sound at most: for very soft tissue and a very quick hand.
/// Across the push and backwards the tool is free; it doesn't slide off a slope, as it would along the skin. Where no
/// value is beyond its begin, the tool is the hand, bit for bit.
/// Without contact it is free, too. After the tissue was put back (a reset, an undo, a solution that was lost) the hand
/// may still be deep: then the tool comes gently until it has been where the hand is for a while.
///
/// Depends on the hand's poses, the state and the last tick's report alone: a replay of the hand repeats it.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/tool_proxy_test.cpp
class ToolProxy {
 public:
  // After the tissue was put back.
  static constexpr double approach_speed = 0.2;  // m/s, up to the skin
  static constexpr double gentle_speed = 0.02;   // m/s, deeper
  static constexpr double arrival_seconds = 0.5;
  /// m/s, at which jaws that touch close or give way: quicker, and a tick's step would pass a small max_force.
  static constexpr double closing_speed = 0.05;

  /// @param tool  that it is for
  explicit ToolProxy(const Model& model, int tool = 0);

  /// The tool's target in the coming tick.
  /// @param hand  where the tool would be without tissue
  /// @param last  the tick before's outcome
  ToolPosture follow(const ToolPosture& hand, const State& state, const StepReport& last);

  /// In the coming tick it touches nothing (Command::lets_go).
  bool letsGo() const { return memory_.lets_go; }

  /// How far its jaws are open at the tick's end, m: as a tool that advances yields to what it presses, jaws that close
  /// yield to what they pinch. At their grip_force they close no further within the step.
  double followOpening(double wanted, const State& state, const StepReport& last) const;

  /// The tissue was put back.
  void beGentle();

  /// The body has other nodes, of which states are from now on.
  void goOnWith(const Model& model) { at_ = &model; }

  /// What the next call depends on beside its arguments.
  struct Memory {
    bool gentle = false;
    int arrived_ticks = 0;  // in a row, while gentle
    bool lets_go = false;
    int let_go_ticks = 0;
    SnagWatch::Memory snag;
  };
  Memory memory() const {
    Memory memory = memory_;
    memory.snag = snag_.memory();
    return memory;
  }
  void recall(const Memory& memory) {
    memory_ = memory;
    snag_.recall(memory.snag);
  }

  /// After the tick that it led to: m, how far the tool stays behind the hand because it yields, or is at its
  /// max_force; 0: it does not.
  double yieldAfter(const Pose& hand, const State& state, const StepReport& report) const;

  /// g above: 1 free, 0 no further.
  double freedom(const StepReport& last) const;

  /// The same for drawing the skin out, and the way in which the tool does, unit: mean displacement of what it touches,
  /// less that of the body as a whole; 0: it touches nothing.
  double freedomToDraw(const State& state) const;
  Vec3 drawnWay(const State& state) const;

 private:
  Vec3 inOneTick(const Vec3& move) const;
  void letGoWhereStuck(const State& state, const Vec3& hand, const StepReport& last);
  bool isOutside(const State& state, const Vec3& hand, const StepReport& last);
  Pose followFrom(const State& state, const Pose& hand, const Vec3& force, const StepReport& last);
  Pose yieldFrom(const Pose& from, const Pose& hand, const Vec3& force, double g);

  const Model& model_;
  const Model* at_;  // of the same body: the present place's
  int tool_;
  double max_speed_;  // m/s
  const int arrival_ticks_;
  const double max_advance_;  // m a tick in tissue
  SnagWatch snag_;
  Memory memory_;                    // but for snag_'s
  std::vector<Vec3f> skin_scratch_;  // (skin vertex_count)
  double yield_ = 0;
};

}  // namespace palpate
