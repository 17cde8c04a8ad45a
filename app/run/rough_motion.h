#pragma once

#include <array>
#include <random>
#include <vector>

#include "app/run/rest_watch.h"
#include "app/run/soak_motion.h"
#include "model/body.h"
#include "realtime/loop/tool_motion.h"

namespace palpate::app {

/// A rough hand, from one seed: it pokes at 0.5 m/s through the bottom, presses and holds, drags through the organ,
/// jumps anywhere at once, while friction (0 to 1) and the stiffness of the materials (all or half of the scene's)
/// change. After each round of some such acts it lifts off, higher where a fold hangs on the tool, and waits until the
/// tissue is at rest: a cycle. Where the tool can't follow upwards, since the organ lies on it, the hand tries to leave
/// downwards, and then aside. What it does does not depend on the tissue but for this, the height and the wait.
class RoughMotion final : public SoakHand {
 public:
  static constexpr double poke_speed = 0.5;  // m/s

  /// @param most_nodes  as RestWatch's
  RoughMotion(const Body& model, unsigned seed, int most_nodes = 0);

  Pose next(const State& state, const StepReport& last) override;
  const Request* nextSetting() override;
  void restart() override;

  SpscRing<SoakCycle>& cycles() override { return cycles_; }
  const RestWatch& rest() const override { return rest_; }

 private:
  /// The hand goes to `goal` (m, in the frame of the tool's start) at `speed` (m/s; 0: at once) and stays `hold` s.
  struct Leg {
    Vec3 goal = Vec3::Zero();
    double speed = 0, hold = 0;
  };

  void planRound();
  void planAct();
  void planSettings();
  void add(const Vec3& goal, double speed, double hold) { legs_[leg_count_++] = {goal, speed, hold}; }
  void advance();  // the hand along its present leg
  double endOf(const Vec3& way) const;
  bool stillLifts(const StepReport& last);
  void watch(const State& state, const StepReport& last);
  double uniform(double low, double high);
  Vec3 place(double low_share, double high_share);

  static constexpr std::size_t most_acts = 4, legs_per_act = 3;

  const Pose start_;
  const double tick_seconds_;
  const std::vector<Material> materials_;  // the scene's
  const unsigned seed_;
  Vec3 low_, high_;           // m, the skin's box in the frame of the tool's start
  Vec3 slid_ = Vec3::Zero();  // m, how far what nothing holds has gone, in the frame of the tool's start
  double lift_ = 0;           // m, height there at which the tool is above all of the skin
  RestWatch rest_;

  SpscRing<SoakCycle> cycles_{1024};
  std::mt19937 random_;
  std::array<Leg, most_acts * legs_per_act + 1> legs_;
  std::size_t leg_count_ = 0, leg_ = 0;  // leg_ == leg_count_: resting
  Vec3 hand_ = Vec3::Zero();             // m, in the frame of the tool's start
  double held_ = 0;                      // s
  double touched_ = 0;                   // s, at the end of a way out
  std::size_t tries_ = 0;                // of the ways out, that have not freed it
  std::array<Request, 2> settings_;
  std::size_t setting_count_ = 0, setting_ = 0;
  SoakCycle cycle_;
};

}  // namespace palpate::app
