#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "realtime/channels/spsc_ring.h"
#include "realtime/loop/tool_motion.h"
#include "simulation/body.h"

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
  std::uint32_t flags = 0;  // StepFlag
  bool rested = false;      // came to rest before longest_rest_s
  double rest_s = 0;        // from the tool's lift-off to rest
  double rest_speed = 0;    // m/s, of the fastest node in the last tick
  double drift_m = 0;       // largest |u - u after the first cycle| of a node
};

/// Endless cycles of a tool: to a place, down, in, across, out and away, each at a speed and depth of its
/// own, from one seed; then it waits, lifted off, until the tissue is at rest.
///
/// At rest: for rest_hold_s no node went faster than restSpeed(). Mass-proportional damping c lets an
/// oscillating mode decay with exp(-c t / 2) (paper eq. 8), so from speed v it still goes about 2 v / c;
/// the bound is chosen so that this is a tenth of the drift that is promised. (A hundredth would be below
/// what float rounding keeps moving: some 3e-8 m/s in the liver.) Slow overdamped modes of very soft or
/// strongly damped scenes go further, which would show as drift. Scenes that do not come to rest in
/// longest_rest_s (damping 0) say so in `rested`.
class SoakMotion final : public ToolMotion {
 public:
  static constexpr double rest_hold_s = 0.1;
  static constexpr double longest_rest_s = 30;
  static constexpr double drift_limit = 1e-6;  // of the organ's size: what a rest may differ from the first

  /// @param places  at least one
  SoakMotion(const Body& model, std::vector<SoakPlace> places, unsigned seed);

  Pose next(const State& state, const StepReport& last) override;
  void restart() override;

  /// (one reader) Cycles that have ended. Holds 1024; more are lost.
  SpscRing<SoakCycle>& cycles() { return cycles_; }
  double restSpeed() const { return rest_speed_; }  // m/s
  double organSize() const { return organ_size_; }  // m, diagonal of the nodes' bounding box

 private:
  struct Leg {
    double advance = 0;                               // m, where it ends
    Eigen::Vector2d slide = Eigen::Vector2d::Zero();  // m
    double seconds = 0;
  };

  void plan();
  void watch(const State& state, const StepReport& last);
  void endCycle(const State& state);
  double uniform(double low, double high);
  double oneOf(double low, double high, double distance);
  Pose poseAt(const Leg& from, const Leg& to, double share) const;

  const Pose start_;
  const double tick_seconds_;
  const double dt_;
  const double tool_radius_;
  const std::vector<SoakPlace> places_;
  const unsigned seed_;
  double organ_size_ = 0;
  double rest_speed_ = 0;
  double lift_ = 0;  // m, advance at which the tool is above all of the skin

  SpscRing<SoakCycle> cycles_{1024};
  std::mt19937 random_;
  std::array<Leg, 5> legs_;
  std::size_t leg_ = 0;  // legs_.size(): resting
  Leg from_;
  double leg_time_ = 0;    // s
  double rest_time_ = 0;   // s since lift-off
  double still_time_ = 0;  // s below rest_speed_
  SoakCycle cycle_;
  bool has_first_rest_ = false;
  AlignedVector<Float4> first_rest_;  // (node_count) m
};

}  // namespace palpate::app
