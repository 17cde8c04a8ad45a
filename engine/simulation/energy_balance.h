#pragma once

namespace palpate {

/// Signs that the steps make energy of nothing, both held against the largest energy of late.
///
/// 1. Motion that alternates from step to step. Central differences keep E* = U + T - Q with Q = dt^2/8 a . M a, of which
///    Q is small for what they resolve, (omega dt)^2 / 4 of a mode's energy; beyond the stable step the fastest modes
///    grow with Q as large as T.
/// 2. A strain energy U that departs from the work done on the internal forces, W_n = -sum_k (f_k + f_(k+1)) / 2 . du_(k+1).
///    In a linear body these are equal whatever the step; where deformation changes the stiffness faster than the
///    steps follow, they part. What they part by is forgotten after a while, so that the roundings of hours do not add up.
struct EnergyBalance {
  double work = 0;       // J, W
  double mismatch = 0;   // J, U - W when last looked
  double drift = 0;      // J, by how much that changed of late
  double scale = 0;      // J, largest U + T of late
  bool fresh = true;     // the next look has nothing to compare with (start, materials changed)

  /// Takes the energies of a step, J.
  /// @param alternating  Q
  /// @param floor        energy below which is rounding
  /// @return (|drift| + Q) / scale
  double look(double strain, double kinetic, double alternating, double dt, double floor);
};

}  // namespace palpate
