#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "app/run/rest_watch.h"
#include "model/body.h"
#include "realtime/channels/spsc_ring.h"
#include "realtime/loop/tool_motion.h"

namespace palpate::app {

/// A place to press, seen along the tool's axis from its start pose.
struct SoakPlace {
  Eigen::Vector2d slide = Eigen::Vector2d::Zero();  // m along the tool's x and y axes
  double touch = 0;                                 // m the tool advances there to the first touch
  double depth = 0;                                 // m it may press
};

/// One cycle, told when the tissue has come to rest after it.
struct SoakCycle {
  std::int64_t number = 0;    // 1: the first
  std::int64_t end_tick = 0;  // of the physics
  double depth_m = 0;
  double peak_force_N = 0;
  float min_J = 1;
  std::uint32_t flags = 0;      // StepFlag
  std::int64_t not_finite = 0;  // ticks with a number that was not finite
  bool rested = false;          // came to rest before longest_rest_s
  double still_s = 0;           // it was still for so long before end_tick
  double rest_s = 0;            // from the tool's lift-off to rest
  double rest_speed = 0;        // m/s, of the fastest node in the last tick
  double drift_m = 0;           // largest |u - u after the first cycle| of a node
};

/// Takes a tick's report into its cycle.
void addTick(SoakCycle& cycle, const StepReport& report);

/// Moves a soak's tool, without end, in cycles after each of which the tissue comes to rest.
class SoakHand : public ToolMotion {
 public:
  /// (one reader) Cycles that have ended. Holds 1024; more are lost.
  virtual SpscRing<SoakCycle>& cycles() = 0;
  virtual const RestWatch& rest() const = 0;
};

/// Endless cycles of a tool: to a place, down, in, across, out and away, each at a speed and depth of its
/// own, from one seed; then it waits, lifted off, until the tissue is at rest (rest_watch.h).
class SoakMotion final : public SoakHand {
 public:
  /// @param places  at least one
  SoakMotion(const Body& model, std::vector<SoakPlace> places, unsigned seed, int most_nodes = 0);

  Pose next(const State& state, const StepReport& last) override;
  void restart() override;

  SpscRing<SoakCycle>& cycles() override { return cycles_; }
  const RestWatch& rest() const override { return rest_; }

 private:
  struct Leg {
    double advance = 0;                               // m, where it ends
    Eigen::Vector2d slide = Eigen::Vector2d::Zero();  // m
    double seconds = 0;
  };

  void plan();
  void watch(const State& state, const StepReport& last);
  double uniform(double low, double high);
  double oneOf(double low, double high, double distance);
  Pose poseAt(const Leg& from, const Leg& to, double share) const;

  const Pose start_;
  const double tick_seconds_;
  const double tool_radius_;
  const std::vector<SoakPlace> places_;
  const unsigned seed_;
  RestWatch rest_;
  double lift_ = 0;  // m, advance at which the tool is above all of the skin

  SpscRing<SoakCycle> cycles_{1024};
  std::mt19937 random_;
  std::array<Leg, 5> legs_;
  std::size_t leg_ = 0;  // legs_.size(): resting
  Leg from_;
  double leg_time_ = 0;  // s
  SoakCycle cycle_;
};

}  // namespace palpate::app
