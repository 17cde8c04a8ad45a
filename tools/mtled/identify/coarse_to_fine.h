#pragma once

#include <stdexcept>

#include "mtled/identify/identify.h"

namespace palpate::tools {

/// A scene's answer to values, always as many numbers; may throw std::runtime_error for values that can't be.
using Answer = std::function<std::vector<double>(const std::vector<double>& values)>;

/// The coarse answers are of no use.
struct CoarseFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What identify finds, and what it took.
struct CoarseToFine {
  Identified found;
  int fine_solves = 0, coarse_solves = 0;
};

/// Values at which `fine` answers as measured, found on `coarse`, which is like it and much cheaper. After each answer
/// f_k of the fine one the search goes on with
///
///   fine(v) ~ f_k + S (coarse(v) - coarse(v_k)),   S = |f_k| / |coarse(v_k)|
///
/// until it stays where it is: two or three fine answers where the two differ by a factor (space mapping: Bandler et
/// al., IEEE Trans. Microw. Theory Tech. 52, 337 (2004); with this model: Echeverria & Hemker, Comput. Methods Appl.
/// Math. 5, 107 (2005)). S is then corrected to take the last way as the fine one does (Broyden). The residuals are the
/// fine one's, to first order at the values found; their derivatives are S times the coarse one's.
/// Throws CoarseFailed where the coarse one can't answer at the start, or does not feel what is sought (which may be of
/// a layer that is thinner than its spacing).
CoarseToFine identifyCoarseToFine(const std::vector<SoughtParameter>& sought, const std::vector<double>& measured,
                                  const Answer& coarse, const Answer& fine);

/// The search on the fine one alone.
CoarseToFine identifyFine(const std::vector<SoughtParameter>& sought, const std::vector<double>& measured,
                          const Answer& fine);

}  // namespace palpate::tools
