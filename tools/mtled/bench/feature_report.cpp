#include "mtled/bench/feature_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "base/number_text.h"
#include "mtled/report/case_result.h"
#include "mtled/report/report_page.h"

namespace palpate::tools {
namespace {

std::string percent(double share) { return std::isfinite(share) ? format("%+.2f %%", 100 * share) : ""; }

}  // namespace

std::string FeatureRow::verdict() const {
  if (std::isnan(limit)) return "";
  if (std::isfinite(more_instructions)) return more_instructions <= limit ? "held" : "missed";
  if (!(uncertainty <= 0.5 * limit)) return "too noisy";
  return more <= limit ? "held" : "missed";
}

bool FeatureReport::held() const {
  return std::all_of(rows.begin(), rows.end(),
                     [](const FeatureRow& r) { return std::isnan(r.limit) || r.verdict() == "held"; });
}

void printFeatures(std::ostream& out, const FeatureReport& report) {
  out << "  " << report.build << "\n  " << report.processor << ", one thread; a box of " << report.nodes
      << " nodes and " << report.points << " points, " << report.substeps << (report.substeps == 1 ? " step" : " steps")
      << " a tick\n\n";
  const bool counted = report.no_instructions.empty();
  ResultTable price{
      "What it costs when it is on", {"feature", "on", "off", "tick on, us", "tick off, us", "more", "+-"}, {}, ""};
  ResultTable rest{"What is left of it when it is off",
                   {"off", "step as it is", "beside", "tick, us", "without, us", "more", "+-", "limit", "verdict"},
                   {},
                   ""};
  if (counted) {
    price.columns.emplace_back("instructions");
    rest.columns.emplace_back("instructions");
  }
  for (const auto& r : report.rows) {
    std::vector<std::string> cells = {r.name,
                                      r.with,
                                      r.without,
                                      format("%.1f", r.with_us),
                                      format("%.1f", r.without_us),
                                      percent(r.more),
                                      format("%.2f", 100 * r.uncertainty) + " %"};
    if (std::isfinite(r.limit)) cells.insert(cells.end(), {format("%.0f", 100 * r.limit) + " %", r.verdict()});
    if (counted) cells.push_back(percent(r.more_instructions));
    (std::isfinite(r.limit) ? rest : price).rows.push_back(cells);
  }
  printTable(out, price);
  out << '\n';
  printTable(out, rest);
  out << "\n  Processor time of a tick; more: median over short rounds that take turns, +- its standard error.";
  if (!counted) out << " Instructions can't be counted on this machine (" << report.no_instructions << ").";
  out << "\n  Adaptive points, refinement, prescribed motions and overlays have no code in the step: off, there is "
         "nothing left of them.\n";
}

std::string jsonOf(const FeatureReport& report) {
  using Json = nlohmann::ordered_json;
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  Json rows = Json::array();
  for (const auto& r : report.rows)
    rows.push_back({{"feature", r.name},
                    {"with", r.with},
                    {"without", r.without},
                    {"with_us", number(r.with_us)},
                    {"without_us", number(r.without_us)},
                    {"more", number(r.more)},
                    {"more_uncertainty", number(r.uncertainty)},
                    {"more_instructions", number(r.more_instructions)},
                    {"limit", number(r.limit)},
                    {"verdict", r.verdict()}});
  const Json json = {{"build", report.build},
                     {"command", report.command},
                     {"processor", report.processor},
                     {"nodes", report.nodes},
                     {"points", report.points},
                     {"substeps", report.substeps},
                     {"instructions_not_counted", report.no_instructions},
                     {"features", rows}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace palpate::tools
