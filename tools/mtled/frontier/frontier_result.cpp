#include "mtled/frontier/frontier_result.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>
#include <utility>

#include "base/number_text.h"
#include "io/result_csv.h"
#include "mtled/report/pictures.h"
#include "mtled/report/vector_json.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::ordered_json;

std::string percent(double share) { return std::isfinite(share) ? format("%.2f %%", share * 100) : "-"; }

/// Every field of a row with its name in the file.
template <class Row, class Each>
void eachField(Row& r, Each each) {
  each("group", r.group);
  each("name", r.name);
  each("nodes", r.nodes);
  each("points", r.points);
  each("substeps", r.substeps);
  each("threads", r.threads);
  each("dt_s", r.dt);
  each("setup_s", r.setup_seconds);
  each("us_per_ms", r.cost.us_per_ms);
  each("tick_p50_us", r.cost.tick_p50);
  each("tick_p999_us", r.cost.tick_p999);
  each("realtime_factor", r.realtime_factor);
  each("force_error", r.error.force);
  each("displacement_error", r.error.displacement);
  each("peak_force_N", r.peak_force);
  each("min_J", r.min_J);
  each("trouble", r.trouble);
}

}  // namespace

std::vector<int> bestRows(const Frontier& frontier) {
  std::vector<double> cost, error;
  for (const auto& row : frontier.rows) {
    cost.push_back(row.cost.us_per_ms);
    error.push_back(row.error.force);
  }
  return paretoFront(cost, error);
}

void printFrontier(std::ostream& out, const Frontier& f) {
  const auto best = bestRows(f);
  const auto line = [&](const std::string& name, const char* pattern, auto... values) {
    out << "  " << name << std::string(name.size() < 34 ? 34 - name.size() : 1, ' ') << format(pattern, values...)
        << "\n";
  };
  line("setting", "%7s %8s %9s %9s %9s %8s %9s", "nodes", "points", "us / ms", "p99.9 us", "real time", "force",
       "displ.");
  for (std::size_t k = 0; k < f.rows.size(); ++k) {
    const auto& row = f.rows[k];
    const bool on_front = std::find(best.begin(), best.end(), static_cast<int>(k)) != best.end();
    line((on_front ? "* " : "  ") + row.name, "%7d %8d %9.0f %9.0f %8.2fx %8s %9s  %s", row.nodes, row.points,
         row.cost.us_per_ms, row.cost.tick_p999, row.realtime_factor, percent(row.error.force).c_str(),
         percent(row.error.displacement).c_str(), row.trouble.c_str());
  }
  out << "  * none is both cheaper and closer. us / ms: computing time per millisecond of physics; real time: the "
         "factor that it could\n"
         "  reach; force, displ.: distance from the reference, "
      << f.reference.nodes << " nodes and " << f.reference.points << " points, which itself is "
      << percent(f.reference.convergence.force) << " and " << percent(f.reference.convergence.displacement)
      << "\n  away from the solution with " << f.reference.coarser_nodes << " nodes.\n";
}

std::string csvOf(const Frontier& f) {
  std::ostringstream out;
  out.precision(9);
  const char* separator = "";
  FrontierRow none;
  eachField(none, [&](const char* name, const auto&) { out << std::exchange(separator, ",") << name; });
  out << '\n';
  for (const auto& r : f.rows) {
    separator = "";
    eachField(r, [&](const char*, const auto& value) { putCsv(out << std::exchange(separator, ","), value); });
    out << '\n';
  }
  return out.str();
}

std::string jsonOf(const Frontier& f) {
  Json rows = Json::array();
  for (const auto& r : f.rows) {
    Json j;
    eachField(r, [&](const char* name, const auto& value) { j[name] = value; });
    rows.push_back(std::move(j));
  }
  Json front = Json::array();
  for (const int k : bestRows(f)) front.push_back(f.rows[static_cast<std::size_t>(k)].name);
  Json reference;
  eachReferenceField(f.reference, [&](const char* name, const auto& value) { reference[name] = value; });
  const Json json = {{"scene", f.scene},       {"way", f.way},         {"build", f.build},
                     {"identity", f.identity}, {"rate_hz", f.rate_hz}, {"reference", reference},
                     {"pareto_front", front},  {"rows", rows}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Frontier frontierFromJson(const std::string& text) {
  try {
    const Json j = Json::parse(text);
    Frontier f{j.at("scene"), j.at("way"), j.at("build"), j.at("identity"), j.at("rate_hz"), {}, {}};
    const Json& reference = j.at("reference");
    eachReferenceField(f.reference, [&](const char* name, auto& value) { readJson(reference.at(name), value); });
    for (const Json& r : j.at("rows")) {
      FrontierRow row;
      eachField(row, [&](const char* name, auto& value) { readJson(r.at(name), value); });
      f.rows.push_back(std::move(row));
    }
    return f;
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(std::string("frontier in JSON: ") + error.what());
  }
}

Figure frontierFigure(const Frontier& f) {
  Figure figure;
  figure.title = f.scene + ": what a microsecond buys";
  figure.x_label = "Computing time per millisecond of physics, us";
  figure.y_label = "Force error, % of the largest force";
  figure.log_x = figure.log_y = true;
  const auto best = bestRows(f);
  Series front{"best", {}, {}, SeriesStyle::Step, ink_colour};
  for (const int k : best) {
    front.x.push_back(f.rows[static_cast<std::size_t>(k)].cost.us_per_ms);
    front.y.push_back(100 * f.rows[static_cast<std::size_t>(k)].error.force);
  }
  figure.series.push_back(front);
  std::vector<std::string> groups;
  for (const auto& row : f.rows)
    if (std::find(groups.begin(), groups.end(), row.group) == groups.end()) groups.push_back(row.group);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    Series series{groups[g],
                  {},
                  {},
                  SeriesStyle::Points,
                  groups[g] == "present" ? ink_colour : static_cast<int>((g - 1) % figure_colour_count)};
    for (std::size_t k = 0; k < f.rows.size(); ++k) {
      const auto& row = f.rows[k];
      if (row.group != groups[g]) continue;
      if (std::find(best.begin(), best.end(), static_cast<int>(k)) != best.end() || g == 0)
        series.highlighted.push_back(static_cast<int>(series.x.size()));
      series.x.push_back(row.cost.us_per_ms);
      series.y.push_back(100 * row.error.force);
      series.point_labels.push_back(row.name);
    }
    figure.series.push_back(series);
  }
  figure.marks.push_back({"real time", 1000, false, ink_colour});
  if (std::isfinite(f.reference.convergence.force))
    figure.marks.push_back({"the reference's own", 100 * f.reference.convergence.force, true, ink_colour});
  return figure;
}

}  // namespace palpate::tools
