#pragma once

#include <iosfwd>
#include <limits>
#include <string>
#include <vector>

namespace palpate::tools {

/// What two loops cost that differ in one thing.
struct FeatureRow {
  std::string name;                                         // "contact"
  std::string with, without;                                // "a ball pressed in 3 mm", "the ball out of reach"
  double limit = std::numeric_limits<double>::quiet_NaN();  // of `more`; NaN: the price of something that is on
  double with_us = 0, without_us = 0;                       // processor time of a tick, median, us
  double more = 0;                                          // median of with / without - 1 over the rounds
  double uncertainty = 0;                                   // its standard error
  double more_instructions = std::numeric_limits<double>::quiet_NaN();  // with / without - 1; NaN: not counted

  /// "held", "missed", or "too noisy" where the uncertainty is above half the limit; "" for a price. By instructions
  /// where they are
  /// counted: they are the same on every run.
  std::string verdict() const;
};

struct FeatureReport {
  std::string build, command, processor;
  int nodes = 0, points = 0, substeps = 0;
  std::string no_instructions;  // why instructions were not counted; "" where they were
  std::vector<FeatureRow> rows;

  bool held() const;  // all that has a limit is
};

void printFeatures(std::ostream& out, const FeatureReport& report);
/// NaN as null.
std::string jsonOf(const FeatureReport& report);

}  // namespace palpate::tools
