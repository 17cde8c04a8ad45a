#pragma once

#include <string>
#include <vector>

namespace palpate::tools {

/// A measured value and what it may be at most (or must be at least).
struct Bound {
  std::string quantity;  // "Reaction at full compression, relative error"
  double value = 0;
  double limit = 0;
  bool at_most = true;  // else at least
  std::string unit;     // of both: "m", "Pa", "%", "" ...
  std::string note;     // where the limit comes from

  /// False for NaN, in the value or in the limit.
  bool held() const;

  /// How much of the limit is used up: 1 at the limit, above 1 where it is not held.
  double use() const;
};

struct ResultTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  // (row_count, column_count), formatted
  std::string note;
};

struct CaseFigure {
  std::string file;  // relative to the report's folder
  std::string caption;
};

/// What a verification case found.
struct CaseResult {
  std::string name;  // on the command line, and of its files: "gel_cylinder"
  std::string title;
  std::string reference;  // where the reference comes from
  std::string text;       // what is compared and how; Markdown
  std::vector<ResultTable> tables;
  std::vector<Bound> bounds;
  std::vector<CaseFigure> figures;
  double seconds = 0;  // wall time of the case

  /// All bounds are. A case without bounds proves nothing and is not held.
  bool held() const;

  /// The bound that is used up most; null where there is none.
  const Bound* worstBound() const;
};

/// Three significant digits with a prefix where the unit takes one ("1.23 mm", "45.6 kPa"); else
/// plain from 0.001 to 99999 ("12.3 %") and scientific beyond ("4.56e-05"). "NaN", "inf" as they are.
std::string formatted(double value, const std::string& unit = "");

/// The same with a sign in any case: "+1.23 %".
std::string formattedSigned(double value, const std::string& unit = "");

/// A relative value in percent: 0.0123 is "1.23 %".
std::string formattedPercent(double share);

}  // namespace palpate::tools
