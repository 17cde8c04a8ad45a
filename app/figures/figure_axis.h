#pragma once

#include <string>
#include <vector>

namespace palpate::app {

/// A place on an axis. Minor ticks have no label.
struct Tick {
  double value = 0;
  std::string label;
};

/// One axis of a figure: which values it shows and where they stand in the picture.
struct Axis {
  bool log = false;
  double low = 0, high = 1;   // shown values; > 0 on a logarithmic axis
  double begin = 0, end = 1;  // px of low and high; begin > end on an axis that points up
  std::vector<Tick> ticks;    // within [low, high], rising
  std::string factor;         // "×10⁻³": what the labels are to be multiplied by; mostly empty

  /// px of a value; NaN where it has no place (not finite, or <= 0 on a logarithmic axis).
  double at(double value) const;
};

/// The least and the largest of the values that an axis can show.
struct Range {
  double low = 0, high = 0;
  bool empty = true;

  void add(double value, bool log);
};

/// An axis over [low, high] exactly, with round ticks (linear: 1, 2 or 5 times a power of ten
/// apart; logarithmic: decades, with 2 and 5 between them where there are few decades).
/// @param max_labels   about how many labels have room
/// @param superscripts  whether the font has them and the minus sign; else "1e-3"
Axis axisOver(double low, double high, bool log, int max_labels, bool superscripts = true);

/// `range` with some air around it. A linear axis begins at 0 where that costs little, and is
/// never widened past 0; a logarithmic one holds at least two round values.
Range aired(const Range& range, bool log, double share);

/// "10⁻³", or "1e-3" where there are no superscripts.
std::string powerOfTen(int exponent, bool superscripts);

}  // namespace palpate::app
