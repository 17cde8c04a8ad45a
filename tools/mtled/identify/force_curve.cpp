#include "mtled/identify/force_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/printable_text.h"
#include "io/force_rows.h"
#include "setup/build_model.h"
#include "step/resolution.h"
#include "step/step.h"
#include "step/trust.h"
#include "step/workspace.h"

namespace palpate::tools {
namespace {

constexpr double approach_speed = 0.05;  // m/s; slow enough that the touch is no blow
constexpr std::size_t least_rows = 5;    // fewer tell nothing of a curve

/// Rows of depths above 0 from `first` on, with the mean of those that are as deep.
ForceCurve meanOf(std::vector<ForceRow>::const_iterator first, std::vector<ForceRow>::const_iterator last) {
  std::map<double, std::pair<double, int>> rows;  // depth -> sum of forces, how many
  for (auto row = first; row != last; ++row) {
    if (!(row->depth > 0)) continue;
    auto& [sum, count] = rows[row->depth];
    sum += row->force;
    ++count;
  }
  ForceCurve curve;
  for (const auto& [at, forces] : rows) {
    curve.depth.push_back(at);
    curve.force.push_back(forces.first / forces.second);
  }
  return curve;
}

/// By which share the force fell from the first of some rows to the last, at one depth: of the rows themselves, or of
/// quarters of them; 0 where noise may do as much.
double fallOf(std::vector<ForceRow>::const_iterator first, std::vector<ForceRow>::const_iterator end) {
  constexpr double chance = 3;  // standard deviations
  const auto count = end - first;
  if (count < 3 || !(first->force > 0)) return 0;
  double squares = 0;  // of second differences, which a trend has no part in: of noise of variance 1 they are 6
  for (auto row = first + 2; row != end; ++row)
    squares += std::pow(row->force - 2 * (row - 1)->force + (row - 2)->force, 2);
  const double noise = std::sqrt(squares / 6 / static_cast<double>(count - 2));
  const auto mean = [](std::vector<ForceRow>::const_iterator from, std::ptrdiff_t rows) {
    double sum = 0;
    for (auto row = from; row != from + rows; ++row) sum += row->force;
    return sum / static_cast<double>(rows);
  };
  for (const std::ptrdiff_t rows : {std::ptrdiff_t{1}, count / 4}) {
    if (rows == 0) continue;
    const double fall = mean(first, rows) - mean(end - rows, rows);
    if (std::abs(fall) > chance * noise * std::sqrt(2 / static_cast<double>(rows))) return fall / mean(first, rows);
  }
  return 0;
}

/// How far the force came to lie from that on the way in (MeasuredCurve::change).
/// @param left  the row that ends a hold, where the way out begins
std::vector<double> changeOf(const MeasuredCurve& in, std::vector<ForceRow>::const_iterator left,
                             std::vector<ForceRow>::const_iterator end) {
  constexpr double backlash = 0.02;  // of the deepest: less than that is no way back in
  auto turned = left;
  for (double highest = in.deepest(); turned != end && turned->depth < highest + backlash * in.deepest(); ++turned)
    highest = std::min(highest, turned->depth);
  const ForceCurve out = meanOf(left, turned);
  if (in.fall == 0 && out.depth.size() < 2) return {};
  std::vector<double> change;
  for (std::size_t k = 0; k < in.depth.size(); ++k) {
    double value = -in.fall * in.force[k];
    if (out.depth.size() > 1 && in.depth[k] >= out.depth.front() && in.depth[k] <= out.depth.back()) {
      const double back = forceAt(out, in.depth[k]) - in.force[k];
      if (std::abs(back) > std::abs(value)) value = back;
    }
    change.push_back(value);
  }
  return change;
}

/// s, when the tool was at depth 0: straight on between the rows beside it, or from the first two.
/// @param touched  the first row of a depth above 0, of two at least
double touchTime(std::vector<ForceRow>::const_iterator begin, std::vector<ForceRow>::const_iterator touched) {
  const auto from = touched == begin ? touched : touched - 1, to = from + 1;
  const double way = to->depth - from->depth, time = to->time - from->time;
  return way > 0 ? from->time - time * from->depth / way : touched->time;
}

}  // namespace

MeasuredCurve readForceCurve(const std::string& path) {
  const std::vector<ForceRow> rows = readForceRows(path, true);
  const auto deepest = std::max_element(rows.begin(), rows.end(),
                                        [](const ForceRow& a, const ForceRow& b) { return a.depth < b.depth; });
  // A tool that is held moves by the noise of what measures it: the first row as deep as the deepest ends the way in.
  constexpr double as_deep = 0.995;
  auto arrived = rows.begin();
  while (arrived != rows.end() && arrived->depth < as_deep * deepest->depth) ++arrived;
  MeasuredCurve curve;
  if (arrived != rows.end()) static_cast<ForceCurve&>(curve) = meanOf(rows.begin(), arrived + 1);
  if (curve.depth.size() < least_rows)
    throw InputError({path}, "only " + std::to_string(curve.depth.size()) + " rows on the way in have a depth above 0",
                     "give at least 5, in the order of time");
  const auto touched = std::find_if(rows.begin(), arrived, [](const ForceRow& row) { return row.depth > 0; });
  curve.seconds = std::max(0.0, arrived->time - touchTime(rows.begin(), touched));
  constexpr double held_share = 0.99;  // of the deepest: the tool is held
  const auto left =
      std::find_if(arrived, rows.end(), [&](const ForceRow& row) { return row.depth < held_share * arrived->depth; });
  const auto held =
      std::find_if(arrived, left, [&](const ForceRow& row) { return row.time > arrived->time + longest_press; });
  curve.fall = fallOf(arrived, held);
  curve.held_seconds = (held - 1)->time - arrived->time;
  curve.change = changeOf(curve, left, rows.end());
  return curve;
}

void checkUnits(const MeasuredCurve& measured, const std::string& path, const Model& model) {
  const Vec3 axis = model.tools.first().start.pose.orientation * Vec3::UnitZ();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& X : model.X) {
    low = std::min(low, axis.dot(X));
    high = std::max(high, axis.dot(X));
  }
  const double deepest = measured.deepest(), thick = high - low;
  constexpr double least_share = 1e-5;  // of the thickness: no tool is placed as finely
  if (deepest < thick && deepest > least_share * thick) return;
  throw InputError({path},
                   format("the deepest row is %.4g mm in, and the organ %.4g mm thick along the tool's axis",
                          1e3 * deepest, 1e3 * thick),
                   "name the column after its unit: depth_mm for millimetres, depth_m for metres");
}

void checkUnits(const MeasuredCurve& measured, const std::string& path, double simulated) {
  constexpr double widest = 200;  // fat to cartilage; newtons for millinewtons are further off
  const double force = measured.force.back(), ratio = force / simulated;
  if (ratio > 1 / widest && ratio < widest) return;
  constexpr double just_touches = 1e-5;  // of the measured force
  if (simulated < just_touches * force && !measured.depth.empty())
    throw InputError({path}, format("the scene's tool hardly touches %.4g mm in", 1e3 * measured.deepest()),
                     "name the column after its unit: depth_m for metres, depth_mm for millimetres; where it is right, "
                     "does the tool meet the organ straight on?");
  throw InputError(
      {path},
      format("the force at the deepest row is %.4g N, and that of the scene as it stands %.4g N", force, simulated),
      "name the column after its unit: force_mN for millinewtons, force_N for newtons; where it is "
      "right, give the scene a material nearer to it to begin from");
}

ForceCurve simulateForceCurve(const Model& model, const PressWay& way, int threads) {
  const double rate = model.scene.dynamics.rate_hz;
  const Vec3 axis = model.tools.first().start.pose.orientation * -Vec3::UnitZ();
  const double approach = std::max(model.tools.first().first_contact_travel, 0.0);
  const auto approach_ticks = static_cast<int>(std::ceil(approach / approach_speed * rate));
  const auto press_ticks = std::max(20, static_cast<int>(std::ceil(way.seconds * rate)));
  const auto held_ticks = static_cast<int>(std::ceil(way.held_seconds * rate));
  State state = initialState(model);
  Workspace workspace(model, threads);
  Command command;
  ForceCurve curve;
  StepReport report;
  for (int k = 1; k <= approach_ticks + press_ticks + held_ticks; ++k) {
    if (interrupted()) throw std::runtime_error("interrupted");
    const double depth = way.deepest * std::clamp(k - approach_ticks, 0, press_ticks) / press_ticks;
    const double travel =
        k < approach_ticks ? approach * k / approach_ticks : model.tools.first().first_contact_travel + depth;
    command.tools[0].pose = model.tools.first().start.pose;
    command.tools[0].pose.position += travel * axis;
    report = tick(model, state, command, workspace);
    if (const Doubt doubt = doubtOf(model, report); doubt >= Doubt::Squeezed)
      throw std::runtime_error("at " + std::to_string(1e3 * depth) + " mm the model can't follow: " + doubtText(doubt));
    if (k <= approach_ticks) continue;
    curve.trust.add(doubtOf(model, report), report.expected_error, report.error_force, depth);
    if (k > approach_ticks + press_ticks) continue;
    curve.depth.push_back(depth);
    curve.force.push_back(report.tool_force.norm());
  }
  if (curve.force.back() > 0) curve.fall = 1 - report.tool_force.norm() / curve.force.back();
  addLast(model, state, report, way.deepest, curve.trust);
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
