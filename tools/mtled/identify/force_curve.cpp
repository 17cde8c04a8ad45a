#include "mtled/identify/force_curve.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <stdexcept>

#include "base/input_error.h"
#include "base/interrupt.h"
#include "io/text_file.h"
#include "simulation/build_model.h"
#include "simulation/step.h"
#include "simulation/trust.h"
#include "simulation/workspace.h"

namespace palpate::tools {
namespace {

constexpr double approach_speed = 0.05;  // m/s; slow enough that the touch is no blow
constexpr std::size_t least_rows = 5;    // fewer tell nothing of a curve

/// The cells of a line of CSV without quotes.
std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells{""};
  for (const char c : line) {
    if (c == ',')
      cells.emplace_back();
    else if (c != '\r')
      cells.back() += c;
  }
  return cells;
}

/// Columns of a CSV file that may have words in others, row by row. Throws InputError with the line
/// of what is no number.
std::vector<std::vector<double>> columnsOf(const std::string& path, const std::vector<std::string>& header,
                                           std::istream& lines, const std::vector<std::string>& wanted) {
  std::vector<std::vector<double>> rows;
  int number = 1;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \r") == std::string::npos || line[0] == '#') continue;
    const std::vector<std::string> cells = cellsOf(line);
    std::vector<double>& row = rows.emplace_back();
    for (const std::string& name : wanted) {
      const auto k = static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
      char* end = nullptr;
      row.push_back(k < cells.size() ? std::strtod(cells[k].c_str(), &end) : 0);
      if (k >= cells.size() || end == cells[k].c_str() || *end != '\0')
        throw InputError({path, number, 0},
                         inQuotes(k < cells.size() ? cells[k] : "") + " in " + name + " is no number", "");
    }
  }
  return rows;
}

}  // namespace

ForceCurve readForceCurve(const std::string& path) {
  std::istringstream lines(readWholeFile(path));
  std::string first;
  std::getline(lines, first);
  const std::vector<std::string> header = cellsOf(first);
  const auto has = [&](const char* name) { return std::find(header.begin(), header.end(), name) != header.end(); };
  std::vector<std::string> wanted{has("advance_m") ? "advance_m" : "depth_m"};
  if (has("force_N"))
    wanted.emplace_back("force_N");
  else
    for (const char* component : {"force_raw_N_x", "force_raw_N_y", "force_raw_N_z"}) wanted.emplace_back(component);
  for (const std::string& name : wanted)
    if (!has(name.c_str()))
      throw InputError({path, 1, 0}, "there is no column " + name,
                       "a force curve has the columns depth_m and force_N, or is a run's force.csv");
  const std::vector<std::vector<double>> table = columnsOf(path, header, lines, wanted);
  const auto deepest =
      std::max_element(table.begin(), table.end(), [](const auto& a, const auto& b) { return a[0] < b[0]; });
  std::map<double, std::pair<double, int>> rows;  // depth -> sum of forces, how many
  for (auto row = table.begin(); row != table.end(); ++row) {
    const double force = row->size() == 2 ? std::abs((*row)[1]) : Vec3((*row)[1], (*row)[2], (*row)[3]).norm();
    if (!((*row)[0] > 0) || !std::isfinite((*row)[0]) || !std::isfinite(force)) continue;
    auto& [sum, count] = rows[(*row)[0]];
    sum += force;
    ++count;
    if (row == deepest) break;  // what follows is on the way out
  }
  if (rows.size() < least_rows)
    throw InputError({path}, "only " + std::to_string(rows.size()) + " rows have a depth above 0", "give at least 5");
  ForceCurve curve;
  for (const auto& [at, forces] : rows) {
    curve.depth.push_back(at);
    curve.force.push_back(forces.first / forces.second);
  }
  return curve;
}

ForceCurve simulateForceCurve(const Model& model, double deepest, double seconds) {
  const double rate = model.scene.rate_hz;
  const Vec3 axis = model.tool_start.orientation * -Vec3::UnitZ();
  const double approach = std::max(model.first_contact_travel, 0.0);
  const auto approach_ticks = static_cast<int>(std::ceil(approach / approach_speed * rate));
  const auto press_ticks = std::max(20, static_cast<int>(std::ceil(seconds * rate)));
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  ForceCurve curve;
  for (int k = 1; k <= approach_ticks + press_ticks; ++k) {
    if (interrupted()) throw std::runtime_error("interrupted");
    const double depth = deepest * std::max(k - approach_ticks, 0) / press_ticks;
    const double travel = k < approach_ticks ? approach * k / approach_ticks : model.first_contact_travel + depth;
    command.tool_target = model.tool_start;
    command.tool_target.position += travel * axis;
    const StepReport report = tick(model, state, command, workspace);
    if (const Doubt doubt = doubtOf(model, report); doubt >= Doubt::Squeezed)
      throw std::runtime_error("at " + std::to_string(1e3 * depth) + " mm the model can't follow: " + doubtText(doubt));
    if (k <= approach_ticks) continue;
    curve.depth.push_back(depth);
    curve.force.push_back(report.tool_force.norm());
  }
  return curve;
}

double forceAt(const ForceCurve& curve, double depth) {
  const auto above = std::lower_bound(curve.depth.begin(), curve.depth.end(), depth);
  if (above == curve.depth.end()) return curve.force.back();
  const auto k = static_cast<std::size_t>(above - curve.depth.begin());
  const double d0 = k > 0 ? curve.depth[k - 1] : 0, f0 = k > 0 ? curve.force[k - 1] : 0;
  return f0 + (curve.force[k] - f0) * (depth - d0) / (curve.depth[k] - d0);
}

}  // namespace palpate::tools
