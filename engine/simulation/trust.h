#pragma once

#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

/// From where on each is doubted.
struct TrustLimits {
  // Of the tissue's volume, where Poisson's ratio is 0.45 or more. Not wrong by itself (confined blocks of nu 0.45: exact at
  // 20 %), but the only sign that comes before a free block of nu 0.49 collapses: at 62 % compression; it gives way at 68 %.
  static constexpr double volume_change = 0.02;
  // Mean pressure over the shear modulus, likewise. The nodes' volumes are only as exact as the quadrature: what a
  // pattern of displacements gains from a pressure by that, shear has to hold. Confined blocks of nu
  // 0.48 .. 0.4999, spacings 4.2 .. 7.5 mm, seven seeds, 1 and 4 points a cell, held for 1 .. 6 s: within 1e-5 of the closed
  // form up to 4.25; at 4.5 the first give way, by 6 %.
  static constexpr double pressure = 4.2;
  // The same where cells share points (cell_pairs.h), 1.32 or 2 to a point, four to nine seeds: exact up to 2.5, the first
  // give way at 2.75.
  static constexpr double pressure_of_pairs = 2.4;
  static constexpr double penetration = 0.1;   // of the tool's radius
  static constexpr double min_J = 0.3;         // below which a pointwise energy of K/2 (J - 1)^2 softens
  static constexpr double step_share = 1.0;    // of the stable step
  static constexpr double energy_error = 0.1;  // of the energy of late
};

/// Real-time: no allocation, no lock, no throw.
Doubt doubtOf(const Model& model, const StepReport& report);

/// What it is and what to do, for panels and logs; "" for None.
const char* doubtText(Doubt doubt);
/// One word: "good", "volume", "contact", ...
const char* doubtName(Doubt doubt);

/// Share of the stable step that dt is of, the volume having stiffened: a point's volumetric stiffness goes with the square of
/// the largest singular value of cof F. From |cof F|^2, the product of the singular values being J^2 ~ 1: not less than it is.
/// Materials that were made stiffer live shorten the stable step, too (live_parameters.h).
/// @param max_cof2  largest |cof F|^2 of the points
double stepShare(const Model& model, const LiveParameters& live, double max_cof2);

}  // namespace palpate
