#pragma once

#include <array>
#include <string_view>

#include "mechanics/internal_forces.h"
#include "model/model.h"
#include "model/state.h"

namespace palpate {

/// The limits beyond which a step's numbers are doubted.
struct TrustLimits {
  // Largest local pressure over the shear modulus where points hold the volume, for Poisson's ratios of 0.45 or
  // more. The nodes' volumes are only as exact as the quadrature, so under pressure some patterns of displacement
  // release energy, and only shear stiffness resists them. Measured on confined blocks (nu 0.48 .. 0.4999, spacings 4.2
  // .. 7.5 mm, seven seeds, 1 and 4 points a cell, held for 1 .. 6 s), where it is the same everywhere: within 1e-5 of
  // the closed form up to 4.25; at 4.5 the first blocks fail, with an error of 6 %.
  static constexpr double pressure = 4.2;
  // The same where cells share points (cell_pairs.h). Measured with 1.32 and 2 cells per point, four to nine seeds:
  // exact up to 2.5; the first blocks fail at 2.75.
  static constexpr double pressure_of_pairs = 2.4;
  // Where cells hold it (scene.cell_volume): how far it was measured. Confined blocks of nu 0.499, three seeds, 1 and 2
  // cells per point, are within 1e-5 of the closed form at 5 .. 40.
  static constexpr double pressure_with_cells = 40;
  static constexpr double penetration = 0.1;  // of the tool's radius
  static constexpr double min_J = 0.3;        // below which a pointwise energy of K/2 (J - 1)^2 softens
  // Of a point, for Poisson's ratios of 0.45 or more: nearly incompressible tissue does not lose half of its volume,
  // its points have crumpled. Free blocks pressed by 48 .. 60 %, nu 0.45 and 0.49, with forces 60 .. 80 % too low, have
  // a min J of 0.29 .. 0.54; those with the force of the closed form have 0.83 or more.
  static constexpr double crumpled_J = 0.55;
  static constexpr double step_share = 1.0;  // of the stable step
  // Force that accelerates the mass added to squeezed tissue, as a share of the tool's. Measured on the liver pressed
  // to 40 mm: at 0.05, 0.2, 0.5 m/s shares of 0.010, 0.054, 0.23, and forces off by 0.9, 11, 35 %.
  static constexpr double added_inertia = 0.025;
  static constexpr double energy_error = 0.1;  // of the recent energy (energy_balance.h)
  // Of forces, expected from how fine the cloud is (expected_error.h).
  static constexpr double expected_error = 0.05;
};

/// Real-time: no allocation, no lock, no throw.
Doubt doubtOf(const Model& model, const StepReport& report);

/// A sentence for panels and logs: what is doubted and what to do; "" for None.
const char* doubtText(Doubt doubt);
/// One word: "good", "volume", "contact", ...
const char* doubtName(Doubt doubt);
/// The doubt with that name; None where there is none.
Doubt doubtNamed(std::string_view name);

/// Resolution, where an error is beyond TrustLimits.
Doubt doubtOfError(double expected_error);

/// What a run's or a solution's rows are worth together: the gravest of their doubts, but that of Resolution by the
/// largest error in N over the largest force, of the tool or rigid body that is worst off. First touch is never
/// resolved, and matters little for what a press finds.
class RunTrust {
 public:
  /// @param expected_error, force  as StepReport::expected_error and error_force
  /// @param by                     whose force that is, of max_pressers; -1: what holds the body
  void add(Doubt doubt, double expected_error, double force, double time, int by = 0);

  /// The same of a tick, for all that presses.
  void add(Doubt doubt, const StepReport& report, double time);

  Doubt doubt() const { return gravest_ != Doubt::None || !unresolved() ? gravest_ : Doubt::Resolution; }
  /// s, of the first row with a doubt that counts; < 0: none
  double firstTime() const { return gravest_ != Doubt::None ? first_ : unresolved() ? first_unresolved_ : -1; }
  /// Of the largest force; 1: something was touched, and never long enough for an estimate.
  double expectedError() const;

 private:
  struct Force {
    double error = 0, largest = 0;  // N
  };
  void note(double expected_error, double force, int by);
  bool unresolved() const { return expectedError() > TrustLimits::expected_error; }

  Doubt gravest_ = Doubt::None;
  double first_ = -1, first_unresolved_ = -1;       // s
  std::array<Force, max_pressers + 1> force_ = {};  // of what presses, and of what holds the body
  bool unknown_ = false;
};

/// The time step dt divided by the stable step of the deformed body: above 1 the step is too long.
///
/// Tissue that is squeezed, and fibres that are stretched, are stiffer and shorten the stable step: their laws bound
/// their tangent by squeeze s^2 + other (PointStateOf). s is estimated from the largest |cof F|^2, where the product of
/// the three singular values is J^2 ~ 1; the estimate is never too small. Materials that were made stiffer during the
/// run shorten the stable step, too (live_parameters.h).
/// @param forces  of the step
double stepShare(const Model& model, const LiveParameters& live, const ForceReport& forces);
/// With the materials as they were loaded.
double stepShare(const Model& model, const ForceReport& forces);

}  // namespace palpate
