#include "mtled/frontier/frontier_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/number_text.h"
#include "io/output_file.h"
#include "mtled/report/case_result.h"
#include "mtled/report/report_page.h"

namespace palpate::tools {
namespace {

constexpr const char* refined_group = "refined at the tool";

/// Nothing where there is no such number.
std::string finite(const char* pattern, double value) { return std::isfinite(value) ? format(pattern, value) : ""; }

std::string percentOf(double share) { return finite("%.2f %%", 100 * share); }

bool compared(const FrontierRow& r) {
  return std::isfinite(r.error.force) && r.error.force > 0 && r.cost.us_per_ms > 0;
}

/// One table per group, in their order.
std::vector<ResultTable> settingTables(const Frontier& f) {
  const auto best = bestRows(f);
  std::vector<ResultTable> tables;
  for (std::size_t k = 0; k < f.rows.size(); ++k) {
    const auto& r = f.rows[k];
    if (tables.empty() || tables.back().title != r.group)
      tables.push_back({r.group,
                        {"setting", "nodes", "points", "steps a tick", "us / ms", "p99.9 tick, us", "real time",
                         "force error", "displ. error", ""},
                        {},
                        ""});
    const bool on_front = std::find(best.begin(), best.end(), static_cast<int>(k)) != best.end();
    tables.back().rows.push_back({r.name, std::to_string(r.nodes), std::to_string(r.points), std::to_string(r.substeps),
                                  finite("%.0f", r.cost.us_per_ms), finite("%.0f", r.cost.tick_p999),
                                  finite("%.2fx", r.realtime_factor), percentOf(r.error.force),
                                  percentOf(r.error.displacement),
                                  r.trouble.empty() ? on_front ? "**best**" : "" : r.trouble});
  }
  return tables;
}

CaseResult settingsCase(const Frontier& f) {
  CaseResult one;
  one.name = "settings";
  one.title = "What each setting costs, and how exact it is";
  one.text =
      "One thing is turned at a time, all else is as the scene has it. *us / ms*: computing time per millisecond of "
      "physics; *real time*: the factor that "
      "it could reach at " +
      finite("%g", f.rate_hz) +
      " Hz. *Force error*: root mean square of the difference from the reference over the ticks with contact, over "
      "the largest force; *displ. error*: likewise over points of the surface at the end. **best**: no other setting "
      "is both cheaper and closer.";
  one.reference = "The same scene with " + std::to_string(f.reference.nodes) + " nodes and " +
                  std::to_string(f.reference.points) +
                  " points, one in each cell, finest where the tool works; the largest force is " +
                  formatted(f.reference.peak_force, "N") + ". A solution with " +
                  std::to_string(f.reference.coarser_nodes) + " nodes is " + percentOf(f.reference.convergence.force) +
                  " (force) and " + percentOf(f.reference.convergence.displacement) +
                  " (displacement) away from it: no error below that is told apart.";
  one.bounds.push_back({"Distance of the reference's force from the next coarser solution",
                        100 * f.reference.convergence.force, 5, true, "%", "what is told apart from it"});
  if (withoutPictures().empty())
    one.figures.push_back(
        {"frontier.png",
         "Cost against force error. The line joins the best settings; ringed black: the scene as it is."});
  one.tables = settingTables(f);
  one.seconds = NAN;
  return one;
}

CaseResult refineCase(const Frontier& f) {
  CaseResult one;
  one.name = "refine";
  one.title = "What nodes where the tool works buy";
  one.text =
      "The spacing is given as a multiple of the scene's, away from the tool's way and at it. Beside each what "
      "*uniform* nodes would cost at the same "
      "force error, by the power law through the rows of the spacing above.";
  ResultTable table{
      "", {"setting", "nodes", "force error", "us / ms", "uniform nodes, us / ms", "times as fast"}, {}, ""};
  double most = NAN;
  for (const auto& r : f.rows) {
    if (r.group != refined_group || !compared(r)) continue;
    const double uniform = uniformCostAt(f, r.error.force), gain = uniform / r.cost.us_per_ms;
    if (!(most >= gain)) most = gain;
    table.rows.push_back({r.name, std::to_string(r.nodes), percentOf(r.error.force), finite("%.0f", r.cost.us_per_ms),
                          finite("%.0f", uniform), finite("%.1f", gain)});
  }
  one.tables.push_back(table);
  one.bounds.push_back({"Speed of the best refined setting over uniform nodes of the same error", most, 1, false, "",
                        "else refinement is not worth it here"});
  one.seconds = NAN;
  return one;
}

}  // namespace

double uniformCostAt(const Frontier& f, double force_error) {
  double count = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& r : f.rows) {
    if ((r.group != "present" && r.group != "spacing") || !compared(r)) continue;
    const double log_error = std::log(r.error.force), log_cost = std::log(r.cost.us_per_ms);
    count += 1;
    x += log_error;
    y += log_cost;
    xx += log_error * log_error;
    xy += log_error * log_cost;
  }
  const double slope = (count * xy - x * y) / (count * xx - x * x);
  return count >= 2 && slope < 0 ? std::exp(y / count + slope * (std::log(force_error) - x / count)) : NAN;
}

void writeFrontierPage(const std::string& folder, const std::string& command, const Frontier& frontier) {
  makeFolder(folder);
  const std::string picture = writePicture(folder + "/frontier.png", frontierFigure(frontier));
  Report report;
  report.title = frontier.scene + ": what a microsecond buys";
  report.intro = "What `mtled frontier` found when it followed the tool's way (" + frontier.way +
                 ") with each setting of the scene. Times are of the machine "
                 "that wrote this page; errors are the same everywhere.";
  if (!withoutPictures().empty()) report.intro += "\n\nPicture: " + picture + ".";
  report.command = command;
  report.build = frontier.build;
  report.cases.push_back(settingsCase(frontier));
  if (std::any_of(frontier.rows.begin(), frontier.rows.end(),
                  [](const FrontierRow& r) { return r.group == refined_group; }))
    report.cases.push_back(refineCase(frontier));
  writeReport(folder, report);
}

}  // namespace palpate::tools
