#pragma once

#include <array>

namespace palpate {

/// Signs that the steps make energy of nothing, both held against the largest energy of late.
///
/// 1. Motion that alternates from step to step. Central differences keep E* = U + T - Q with Q = dt^2/8 a . M a, of which
///    Q is small for what they resolve, (omega dt)^2 / 4 of a mode's energy. Beyond the stable step the fastest modes
///    grow by a factor g > 1 a step with Q = (1 + g) / 4g > 1/4 of U + T, in each step. A tool or boundary that strikes
///    sets nodes from 0 to v in one step, which makes a Q of T / 4 as well, but only in that step. What counts is
///    therefore the least share of four successive steps: at first touches of 0.05 .. 2 m/s at most 0.06 (slabs of three
///    spacings, kidney, liver, layer; sphere and flat end; of three steps 0.09, of one 0.25).
/// 2. A strain energy U that departs from the work done on the internal forces, W_n = -sum_k (f_k + f_(k+1)) / 2 . du_(k+1).
///    In a linear body these are equal whatever the step; where deformation changes the stiffness faster than the
///    steps follow, they part. What they part by is forgotten after a while, so that the roundings of hours do not add up.
struct EnergyBalance {
  double work = 0;                              // J, W
  double mismatch = 0;                          // J, U - W when last looked
  double drift = 0;                             // J, by how much that changed of late
  double scale = 0;                             // J, largest U + T of late
  std::array<double, 4> acceleration_shares{};  // Q / scale of the last steps, as a ring
  int next_share = 0;
  bool fresh = true;  // the next look has nothing to compare with (start, materials changed)

  /// Takes the energies of a step, J.
  /// @param acceleration_energy  Q
  /// @param floor        energy below which is rounding
  /// @return |drift| / scale + the least share of Q
  double update(double strain, double kinetic, double acceleration_energy, double dt, double floor);
};

}  // namespace palpate
