#pragma once

#include <cstdint>
#include <vector>

#include "base/types.h"

namespace palpate {

/// A hand and arm that hold a stylus: a grip (spring and damper) between the stylus and the arm's mass, which a spring
/// and a damper hold where the person wants it. That is the third-order structure which Fu and Cavusoglu identified for
/// stylus devices ("Human-arm-and-hand-dynamic model with variability analyses for a stylus-based haptic interface",
/// IEEE Trans. SMC B 42(6), 2012; 15 people, grips of 1 to 3 N). The numbers below are not from their table: they span
/// light to firm grips in the range that such measurements give (e.g. 0.55 kg, 6.5 N s/m, 135 N/m of a whole arm: van
/// Beek et al., Sci. Rep. 5:18004, 2015).
struct HandModel {
  double mass = 0.3;                              // kg, of the arm as it moves along
  double grip_stiffness = 500, grip_damping = 4;  // N/m, N s/m
  double arm_stiffness = 120, arm_damping = 6;

  static HandModel light() { return {0.12, 300, 2, 60, 3}; }
  static HandModel firm() { return {0.55, 1200, 9, 135, 6.5}; }
  /// Fingers that hardly hold it, of an arm that goes where it is wanted.
  static HandModel loose(double stiffness = 5, double damping = 0.2) { return {1, stiffness, damping, 1e4, 200}; }
};

/// Where a person wants the hand, by time: m from where it began.
struct HandMotion {
  enum class Kind {
    Press,   // down, rest there, along, back up, once in `period`
    Random,  // about half that depth, by sines between 0.2 and 4 Hz
    Wander,  // down, rest there, back up, and on to another place within `slide`, once in `period`
  };
  Kind kind = Kind::Press;
  Vec3 down = -Vec3::UnitZ(), along = Vec3::UnitX();  // unit
  double depth = 0.01, slide = 0.005;                 // m
  double period = 4;                                  // s, of Press and Wander
  std::uint64_t seed = 1;                             // of Random and Wander
  double rock = 0, rock_period = 1;                   // rad, to both sides about `along`; s

  Vec3 at(double seconds) const;
  /// The rotation vector, rad.
  Vec3 turnAt(double seconds) const;
};

/// Numbers that are the same on every machine: splitmix64.
class SteadyRandom {
 public:
  explicit SteadyRandom(std::uint64_t seed) : state_(seed) {}
  /// 0 .. 1
  double next();

 private:
  std::uint64_t state_;
};

}  // namespace palpate
