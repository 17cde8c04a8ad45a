#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

#include "mtled/report/case_result.h"

namespace palpate::tools {

/// What a whole run found.
struct Report {
  std::string title = "Verification";
  std::string intro;    // Markdown, may be empty
  std::string command;  // that repeats it: "build/release/tools/mtled verify --report docs"
  std::string build;    // buildInfo()
  std::vector<CaseResult> cases;

  std::size_t missing = 0;  // cases that were not run, or not yet

  bool held() const;  // all cases are, there is one, and none is missing
};

/// A table as plain text with aligned columns, its title above.
void printTable(std::ostream& out, const ResultTable& table);

/// A case as plain text with aligned tables and a verdict per bound.
void printCase(std::ostream& out, const CaseResult& result);

/// One line per case: name, verdict, worst bound, time.
void printSummary(std::ostream& out, const Report& report);

/// A page in GitHub-flavoured Markdown. Holds no date: the same results give the same page, but
/// for the cases' times.
std::string markdownOf(const Report& report);

/// All of it in JSON; NaN and infinities as the strings "nan", "inf", "-inf".
std::string jsonOf(const Report& report);

/// Throws as writeReport where nothing can be written there; what stands there stays.
void checkReport(const std::string& folder);

/// Writes README.md and results.json into a folder, which is made where it is missing.
/// Throws std::runtime_error that names the file and the reason.
void writeReport(const std::string& folder, const Report& report);

}  // namespace palpate::tools
