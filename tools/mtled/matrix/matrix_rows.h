#pragma once

#include <string>
#include <vector>

#include "mtled/matrix/matrix_case.h"
#include "mtled/report/case_result.h"

namespace palpate::tools {

class Pictures;

/// A case, what was answered, and what it should have been.
struct MatrixRow {
  MatrixCase one;
  MatrixAnswer answer;
  MatrixReference reference;
  std::string refused;  // why the scene can't be had

  double error() const { return answer.value / reference.value - 1; }
  double unknown() const { return reference.uncertainty / std::abs(reference.value); }
  bool answered() const { return refused.empty() && answer.sound; }
  /// Its error is known, up to well_known.
  bool comparable() const { return answered() && reference.known && reference.value != 0 && unknown() <= well_known; }
  bool trusted() const { return answered() && answer.trust.doubt() == Doubt::None; }
  /// Trusted, and wrong whatever is not known of the reference.
  bool isLie() const { return trusted() && comparable() && std::abs(error()) - unknown() > lie; }
  /// The error that is expected is within a factor of two of the true one, or both are below worth_a_look.
  bool isHonest() const;
  /// Nothing but resolution is doubted, so that an expected error is given.
  bool isEstimated() const { return answered() && answer.trust.doubt() <= Doubt::Resolution; }

  static constexpr double lie = 0.1;            // trusted, and further off than this
  static constexpr double well_known = 0.02;    // what may be unknown of a reference
  static constexpr double worth_a_look = 0.01;  // of errors: a user does not tell smaller ones apart
};

/// How often what a group of rows says is true.
struct MatrixShares {
  int cases = 0, refused = 0, unsound = 0, doubted = 0;
  int without_reference = 0;                      // answered, but not comparable
  int trusted = 0;                                // and comparable
  int within_2 = 0, within_5 = 0, within_10 = 0;  // of `trusted`, %
  int estimated = 0, honest = 0;                  // comparable and given an expected error; and of these
};
MatrixShares sharesOf(const std::vector<const MatrixRow*>& rows);

/// Tables, bounds and, with pictures, the cloud of errors.
/// @param folder  where pictures go
CaseResult matrixResult(const std::vector<MatrixRow>& rows, Pictures* pictures, const std::string& folder);

}  // namespace palpate::tools
