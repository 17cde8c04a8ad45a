#include "mtled/matrix/matrix_rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/number_text.h"
#include "mtled/report/pictures.h"

namespace palpate::tools {
namespace {

double shareOf(int part, int all) { return all > 0 ? static_cast<double>(part) / all : 1; }

std::string percentOf(int part, int all) {
  return all > 0 ? format("%.0f %%", 100.0 * part / all) : std::string("\u2013");
}

using Rows = std::vector<const MatrixRow*>;

std::vector<std::string> lineOf(const std::string& name, const Rows& rows) {
  const MatrixShares s = sharesOf(rows);
  return {name,
          std::to_string(s.cases),
          std::to_string(s.doubted),
          std::to_string(s.unsound + s.refused),
          std::to_string(s.without_reference),
          std::to_string(s.trusted),
          percentOf(s.within_2, s.trusted),
          percentOf(s.within_5, s.trusted),
          percentOf(s.within_10, s.trusted),
          std::to_string(s.honest) + " of " + std::to_string(s.estimated)};
}

ResultTable sharesTable(const std::vector<MatrixRow>& rows) {
  ResultTable table{"How often a number is true",
                    {"cases", "drawn", "doubted", "no answer, and said so", "no reference", "trusted", "within 2 %",
                     "5 %", "10 %", "expected error honest"},
                    {},
                    "Trusted ones are those of which an error is known. An expected error is honest within a factor of "
                    "two, or where both are below 1 %."};
  Rows all, closed, finer;
  std::map<std::string, Rows> by_kind;
  for (const MatrixRow& row : rows) {
    all.push_back(&row);
    (row.one.hasClosedForm() ? closed : finer).push_back(&row);
    by_kind[row.one.kind].push_back(&row);
  }
  table.rows.push_back(lineOf("all", all));
  table.rows.push_back(lineOf("closed forms", closed));
  table.rows.push_back(lineOf("finer clouds", finer));
  for (const auto& [kind, of_kind] : by_kind) table.rows.push_back(lineOf(kind, of_kind));
  return table;
}

ResultTable worstTable(const std::vector<MatrixRow>& rows) {
  constexpr std::size_t shown = 12;
  ResultTable table{"The trusted ones that are off most",
                    {"seed", "loaded", "error", "not known", "expected", "nodes", "what"},
                    {},
                    ""};
  Rows trusted;
  for (const MatrixRow& row : rows)
    if (row.trusted() && row.comparable()) trusted.push_back(&row);
  std::sort(trusted.begin(), trusted.end(),
            [](const MatrixRow* a, const MatrixRow* b) { return std::abs(a->error()) > std::abs(b->error()); });
  trusted.resize(std::min(trusted.size(), shown));
  for (const MatrixRow* row : trusted)
    table.rows.push_back({std::to_string(row->one.seed), row->one.kind, format("%+.2f %%", 100 * row->error()),
                          format("%.2f %%", 100 * row->unknown()),
                          format("%.2f %%", 100 * row->answer.trust.expectedError()), std::to_string(row->answer.nodes),
                          row->one.about});
  return table;
}

ResultTable doubtsTable(const std::vector<MatrixRow>& rows) {
  ResultTable table{"What is doubted, and how far off it is", {"doubt", "cases", "beyond 5 %", "of known"}, {}, ""};
  struct Count {
    int cases = 0, beyond = 0, known = 0;
  };
  std::map<std::string, Count> counts;
  for (const MatrixRow& row : rows) {
    if (!row.refused.empty()) {
      ++counts["refused"].cases;
      continue;
    }
    if (row.trusted()) continue;
    Count& count = counts[row.answer.sound ? doubtName(row.answer.trust.doubt()) : "no equilibrium"];
    ++count.cases;
    count.known += row.comparable();
    count.beyond += row.comparable() && std::abs(row.error()) > 0.05;
  }
  for (const auto& [doubt, count] : counts)
    table.rows.push_back(
        {doubt, std::to_string(count.cases), std::to_string(count.beyond), std::to_string(count.known)});
  return table;
}

Figure cloudOf(const std::vector<MatrixRow>& rows) {
  constexpr double least = 1e-5, most = 1;  // below, a point lies at the edge
  Figure figure;
  figure.title = "Errors of scenes drawn by lot";
  figure.x_label = "True error of the force";
  figure.y_label = "Expected error";
  figure.log_x = figure.log_y = true;
  figure.x_low = figure.y_low = least;
  figure.x_high = figure.y_high = most;
  Series closed{"trusted, closed form", {}, {}, SeriesStyle::Points},
      finer{"trusted, finer clouds", {}, {}, SeriesStyle::Points}, doubted{"doubted", {}, {}, SeriesStyle::Points};
  for (const MatrixRow& row : rows) {
    if (!row.comparable()) continue;
    Series& series = !row.trusted() ? doubted : row.one.hasClosedForm() ? closed : finer;
    series.x.push_back(std::clamp(std::abs(row.error()), 1.05 * least, 0.95 * most));
    series.y.push_back(std::clamp(row.answer.trust.expectedError(), 1.05 * least, 0.95 * most));
  }
  figure.series = {closed, finer, doubted};
  figure.bands.push_back({"within a factor of two", {least, most}, {least / 2, most / 2}, {2 * least, 2 * most}});
  figure.marks.push_back({"doubted above", TrustLimits::expected_error, true});
  figure.marks.push_back({"a lie if trusted", MatrixRow::lie});
  return figure;
}

}  // namespace

bool MatrixRow::isHonest() const {
  const double expected = answer.trust.expectedError(), is = std::abs(error());
  return std::max(expected, is) < worth_a_look ||
         (expected < 2 * std::max(is + unknown(), worth_a_look / 2) && 2 * expected > is - unknown());
}

MatrixShares sharesOf(const std::vector<const MatrixRow*>& rows) {
  MatrixShares s;
  for (const MatrixRow* row : rows) {
    ++s.cases;
    s.refused += !row->refused.empty();
    s.unsound += row->refused.empty() && !row->answer.sound;
    s.doubted += row->answered() && !row->trusted();
    s.without_reference += row->answered() && !row->comparable();
    if (!row->comparable()) continue;
    s.estimated += row->isEstimated();
    s.honest += row->isEstimated() && row->isHonest();
    if (!row->trusted()) continue;
    const double off = std::abs(row->error());
    ++s.trusted;
    s.within_2 += off <= 0.02;
    s.within_5 += off <= 0.05;
    s.within_10 += !row->isLie();
  }
  return s;
}

CaseResult matrixResult(const std::vector<MatrixRow>& rows, Pictures* pictures, const std::string& folder) {
  CaseResult result;
  result.name = "matrix";
  result.title = "Scenes drawn by lot";
  result.reference =
      "Closed forms (parts that are each strained evenly; equilibria that depend on one coordinate, found as one "
      "dimension's); else two finer clouds of the same engine in double, extrapolated.";
  result.text =
      "Bodies, laws, Poisson's ratios from 0 to 0.499, contrasts to 1 : 100, borders, tools, ways of loading and "
      "spacings follow from a seed: nobody tuned to them.";
  result.tables = {sharesTable(rows), worstTable(rows), doubtsTable(rows)};
  Rows all;
  for (const MatrixRow& row : rows) all.push_back(&row);
  const MatrixShares s = sharesOf(all);
  result.bounds = {
      {"Trusted forces within 2 %", 100 * shareOf(s.within_2, s.trusted), 95, false, "%", "the goal"},
      {"Trusted forces within 5 %", 100 * shareOf(s.within_5, s.trusted), 99, false, "%", "the goal"},
      {"Trusted forces beyond 10 %", static_cast<double>(s.trusted - s.within_10), 0, true, "", "no lie"},
      {"Expected errors within a factor of two", 100 * shareOf(s.honest, s.estimated), 90, false, "%", "the goal"}};
  if (pictures == nullptr) return result;
  pictures->write(folder + "/matrix_errors.png", cloudOf(rows));
  result.figures.push_back({"matrix_errors.png",
                            "True against expected error; below the band errors are larger than "
                            "they are said to be"});
  return result;
}

}  // namespace palpate::tools
