#pragma once

#include <algorithm>

#include "base/types.h"
#include "model/body.h"
#include "model/state.h"

namespace palpate::app {

/// Tells when the tissue has come to rest after a tool has lifted off, and how far from the first rest that is.
///
/// At rest: for rest_hold_s (or longer, if asked) no node went faster than restSpeed(). Mass-proportional damping c
/// lets an oscillating mode decay with exp(-c t / 2) (paper eq. 8), so from speed v it still goes about 2 v / c; the
/// bound is chosen so that this is a tenth of the drift that is promised. (A hundredth would be below what float
/// rounding keeps moving: some 3e-8 m/s in the liver.) Slow overdamped modes of very soft or strongly damped scenes go
/// further, which would show as drift. Tissue under stress trembles faster than that with its coordinates' rounding and
/// goes nowhere: it is at rest, too, where as long no node left a ball of radius restRadius(), which is what the bound
/// on the speed allows it, and somewhat more for a body that has slid far, whose coordinates are coarser. What a
/// further tool of the scene held still comes to rest anew when that lets go. Scenes that do not come to rest in
/// longest_rest_s (damping 0) are told apart by rested().
/// No allocation but in the constructor, no lock, no throw.
class RestWatch {
 public:
  static constexpr double rest_hold_s = 0.1;
  static constexpr double longest_rest_s = 30;
  static constexpr double drift_limit = 1e-6;  // of the organ's size: what a rest may differ from the first
  // The same under a rough hand, m: a hundredth of a hair. What was pressed flat leaves more rounding behind.
  static constexpr double rough_drift_limit_m = 1e-6;

  /// @param hold_s      s, how long it has to be still
  /// @param most_nodes  that a state may have, where the cloud follows the tool; 0: the model's
  explicit RestWatch(const Body& model, double hold_s = rest_hold_s, int most_nodes = 0);

  /// The tool has lifted off: the wait begins.
  void begin() { rest_time_ = still_time_ = near_time_ = 0; }
  /// Another tick. @return true where the wait is over: at rest, or after longest_rest_s
  bool update(const State& state, const StepReport& last);
  /// m, largest |u - u at the first rest| of a node; the first call is that rest. Along axes along which nothing holds
  /// the body it may rest anywhere: there without its mean. 0 where friction's past decides how it rests: where it lies
  /// loose, on another organ, or on what is rigid with friction, and while a further tool touches it. At another place
  /// of a cloud that follows the tool it is the distance from where nothing is moved; where the body has weight or
  /// loads, the first rest is taken anew.
  double driftOf(const State& state);
  /// m, how far the body has gone along axes along which nothing holds it.
  Vec3 slidOf(const State& state) const;
  void forgetFirst() { has_first_ = false; }

  bool rested() const { return std::max(still_time_, near_time_) >= hold_s_; }
  double hold() const { return hold_s_; }           // s, so long it is still then
  double seconds() const { return rest_time_; }     // s since begin()
  double speed() const { return speed_; }           // m/s, of the fastest node in the last tick
  double restSpeed() const { return rest_speed_; }  // m/s
  double restRadius() const;                        // m
  double organSize() const { return organ_size_; }  // m, diagonal of the nodes' bounding box

 private:
  const double hold_s_, tick_seconds_, dt_;
  const Vec3 free_;           // 1 along axes along which nothing holds the body
  const bool rests_unmoved_;  // by itself
  const bool has_past_;       // friction's
  double organ_size_ = 0, rest_speed_ = 0;
  double rest_time_ = 0, still_time_ = 0, near_time_ = 0;        // s
  double speed_ = 0, rounding_ = 0;                              // m/s; m, by how far it has slid
  bool has_first_ = false, held_ = false;                        // held_: a tool touches
  AlignedVector<Float4> first_;                                  // (node_count) m
  AlignedVector<Float4> anchor_;                                 // (node_count) m, at the beginning of near_time_
  PlaceIndex first_place_ = no_place, anchor_place_ = no_place;  // that these are of
};

}  // namespace palpate::app
