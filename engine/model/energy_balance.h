#pragma once

#include <array>

namespace palpate {

/// Two signs that the time steps create energy, both relative to the largest recent energy.
///
/// 1. Motion that alternates from step to step. Central differences conserve E* = U + T - Q with Q = dt^2/8 a . M a.
/// For
///    modes that the step resolves, Q is small: (omega dt)^2 / 4 of a mode's energy. Beyond the stable step the fastest
///    modes grow by a factor g > 1 a step, and Q = (1 + g) / 4g > 1/4 of U + T in each step. An impact of a tool or
///    boundary moves nodes from 0 to v in one step, which makes a Q of T / 4 as well, but only in that step. Therefore
///    the smallest share of four successive steps is used: at first touches of 0.05 .. 2 m/s it is at most 0.06 (slabs
///    of three spacings, kidney, liver, layer; sphere and flat end; for three steps 0.09, for one 0.25).
/// 2. A strain energy U that differs from the work done against the internal forces,
///    W_n = -sum_k (f_k + f_(k+1)) / 2 . du_(k+1). In a linear body the two are equal whatever the step; they differ
///    where deformation changes the stiffness within a step. The difference fades with time, so that the rounding
///    errors of hours do not add up. Where a material relaxes, U is the energy of its law less the work that the
///    relaxation kept from it, which is the integral of sum Q : dE over all motion (mechanics/relaxation.h).
struct EnergyBalance {
  double work = 0;                              // J, W
  double relaxed = 0;                           // J, what relaxation kept from the strain energy
  double relaxation_flow = 0;                   // J, integral of sum dQ/dt : E
  double relaxation_power = 0;                  // W, sum dQ/dt : E at the last update
  double mismatch = 0;                          // J, U - W at the last update
  double drift = 0;                             // J, recent change of `mismatch`
  double scale = 0;                             // J, largest recent U + T
  std::array<double, 4> acceleration_shares{};  // Q / scale of the last steps, as a ring
  int next_share = 0;
  bool fresh = true;  // the next update has no previous value (start, materials changed)

  /// Takes note of what relaxes, before update: sum Q : dE is d(sum Q : E) less sum dQ : E. No point's past strain is
  /// needed.
  /// @param energy, power  of ForceReport
  void relax(double energy, double power, double dt);

  /// Adds the energies of a step, J.
  /// @param acceleration_energy  Q
  /// @param floor        energy below which all is rounding error
  /// @return |drift| / scale + the smallest share of Q
  double update(double strain, double kinetic, double acceleration_energy, double dt, double floor);
};

}  // namespace palpate
