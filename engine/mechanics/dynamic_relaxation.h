#pragma once

namespace palpate {

/// Damping and stopping of dynamic relaxation (paper section 2.3; Joldes, Wittek, Miller 2009, 2011). With
/// lowest and highest frequency w0 and w1 and the step h = 2 / sqrt(w0^2 + w1^2) ~ 2 / w1, the error is multiplied by
///   r = (sqrt(k) - 1) / (sqrt(k) + 1),   sqrt(k) = 2 / (w0 h)
/// in each step of u+ = u + beta du + alpha M^-1 f, the fastest of all such iterations.
class DynamicRelaxation {
 public:
  /// @param h  pseudo-time step, s; at most 2 / w1
  explicit DynamicRelaxation(double h) : h_(h) {}

  double alpha() const { return (1 + r_) * (1 + r_) * h_ * h_ / 4; }  // s^2
  double beta() const { return r_ * r_; }
  double convergenceRate() const { return r_; }
  double step() const { return h_; }
  void setStep(double h) { h_ = h; }
  /// Sets the rate that belongs to a lowest frequency, rad/s.
  void setLowestFrequency(double w0);

  /// Updates the estimate of w0 by the Rayleigh quotient of the displacement U since a reference state and the change
  /// F of the internal forces over it. The lowest modes settle last, so they dominate U.
  /// @param work     -U . F, J      @param inertia  U . M U, kg m^2
  /// An estimate is used when twenty in a row agree within 1 %.
  void observe(double work, double inertia);

  /// Estimated distance of u from equilibrium, in the unit of `increment`: the sum of the geometric series of the
  /// increments still to come, at the rate of a mode somewhat slower than the estimated lowest.
  double remaining(double increment) const;

 private:
  double h_;
  double r_ = 0.99;
  double w2_ = 0;  // candidate, (rad/s)^2
  int agreeing_ = 0;
};

}  // namespace palpate
