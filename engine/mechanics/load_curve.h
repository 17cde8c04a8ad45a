#pragma once

#include <vector>

namespace palpate {

/// The fraction of an imposed motion that is reached at a time: 0 .. 1, or the values of a table.
struct LoadCurve {
  enum class Kind { Smooth, Linear, Table };
  Kind kind = Kind::Smooth;      // Smooth: the 3-4-5 polynomial 10 t^3 - 15 t^4 + 6 t^5
  std::vector<double> time;      // Table: s, ascending, from 0
  std::vector<double> fraction;  // Table: of the motion; linear in between, constant after the last

  /// @param time_s, duration  s; the fraction stays 1 after `duration` (Smooth, Linear)
  /// Real-time: no allocation, no throw.
  double at(double time_s, double duration) const;
};

}  // namespace palpate
