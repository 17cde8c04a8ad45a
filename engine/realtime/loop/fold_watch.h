#pragma once

#include <cstdint>

#include "model/model.h"
#include "model/report.h"

namespace palpate {

/// Finds tissue that has folded: nothing touches or pulls it, it stands still, and yet it is not at rest. A hand rough
/// enough can push a coarse cloud into such an equilibrium, a crumpled edge or a part turned inside out, from which it
/// does not come back by itself: the contact of the skin with itself knows no folds finer than some nodes. What is
/// turned inside out hardly resists and may swing for minutes: what stays crushed for long has folded, still or not.
///
/// Where the stress relaxes, tissue comes back slowly, and where it has weight, it is strained by that, so there only
/// what is crushed counts. Bodies whose boundaries are moved are loaded always: there what counts is a point far
/// smaller than the smallest at a rest before, once the boundaries stand still.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/fold_watch_test.cpp
class FoldWatch {
 public:
  static constexpr double seconds = 0.5;        // so long
  static constexpr double strained = 10;        // Model::rest_energy: a strain of 1 % everywhere, or one crushed cell
  static constexpr double calm = 1e-3;          // kinetic energy as a share of the strain energy
  static constexpr double steady_share = 0.99;  // what the strain energy must not fall below meanwhile
  static constexpr double crushed_seconds = 3;  // where it is crushed and swings: so long, with
  static constexpr double crushed_share = 0.9;  // so much of the strain energy left
  static constexpr double smaller = 0.55;       // of the smallest J at a rest before, where boundaries were moved

  explicit FoldWatch(const Model& model);

  /// A time in which the strain energy stayed what it was.
  struct Stay {
    std::int64_t ticks = 0;
    double energy = 0;  // J, in the first of them

    bool update(double strain_energy, double share, std::int64_t needed);
  };
  /// What its coming verdicts depend on.
  struct Memory {
    Stay still, crushed;  // where it stands still, where a point is crushed
    double rest_J = 0;    // where boundaries were moved: smallest J at rest; 0: not known
  };
  Memory memory() const { return memory_; }
  void recall(const Memory& memory) { memory_ = memory; }

  /// A tick has ended well.
  /// @param pulled  a spring pulls the skin
  /// @param age     s of physics since the tissue was put to rest
  /// @return whether the tissue has folded; then the watch begins anew
  bool update(const StepReport& report, bool pulled, double age);

 private:
  bool isCrushed(const StepReport& report, bool stands, double age);

  const std::int64_t needed_, crushed_needed_;  // ticks
  const double strained_;                       // J
  bool strained_anyway_ = false;
  double moved_until_ = 0;  // s; 0: no boundary is moved
  Memory memory_;
};

}  // namespace palpate
