#include "step/trust.h"

#include <algorithm>
#include <cmath>

namespace palpate {

Doubt doubtOf(const Model& model, const StepReport& report) {
  if (report.flags & (kNotFinite | kBlowUp)) return Doubt::Lost;
  if (report.inverted_points > 0) return Doubt::Inverted;
  if (report.energy_error > TrustLimits::energy_error) return Doubt::Energy;
  if (report.step_share > TrustLimits::step_share || report.added_inertia > TrustLimits::added_inertia)
    return Doubt::Step;
  if (report.min_J < TrustLimits::min_J) return Doubt::Squeezed;
  if ((report.flags & (kContactOverflow | kLetsGo | kDeepContact)) ||
      report.max_penetration > TrustLimits::penetration * model.scene.tools[0].shape.radius)
    return Doubt::Contact;
  const double max_pressure = model.scene.discretization.quadrature.cells_per_point > 1 ? TrustLimits::pressure_of_pairs
                                                                                        : TrustLimits::pressure;
  if (report.nearly_incompressible &&
      (report.min_J < TrustLimits::crumpled_J || report.pressure_over_shear > max_pressure ||
       report.cell_pressure_over_shear > TrustLimits::pressure_with_cells))
    return Doubt::Volume;
  return doubtOfError(report.expected_error);
}

Doubt doubtOfError(double expected_error) {
  return expected_error > TrustLimits::expected_error ? Doubt::Resolution : Doubt::None;
}

void RunTrust::note(double expected_error, double force, int by) {
  unknown_ = unknown_ || (expected_error > 0 && force == 0);
  Force& of = force_[by < 0 ? max_pressers : static_cast<std::size_t>(by)];
  of.largest = std::max(of.largest, force);
  of.error = std::max(of.error, expected_error * force);
}

void RunTrust::add(Doubt doubt, double expected_error, double force, double time, int by) {
  note(expected_error, force, by);
  if (doubt == Doubt::None) return;
  double& first = doubt == Doubt::Resolution ? first_unresolved_ : first_;
  if (first < 0) first = time;
  if (doubt != Doubt::Resolution) gravest_ = std::max(gravest_, doubt);
}

void RunTrust::add(Doubt doubt, const StepReport& report, double time) {
  for (std::size_t t = 0; t < report.loads.size(); ++t)
    if (report.loads[t].expected_error > 0)
      note(report.loads[t].expected_error, report.loads[t].error_force, static_cast<int>(t));
  for (std::size_t b = 0; b < report.rigid.size(); ++b)
    if (report.rigid[b].expected_error > 0)
      note(report.rigid[b].expected_error, report.rigid[b].error_force, max_tools + static_cast<int>(b));
  add(doubt, report.expected_error, report.error_force, time, report.error_by);
}

double RunTrust::expectedError() const {
  double largest = 0, worst = 0;
  for (const Force& of : force_) largest = std::max(largest, of.largest);
  for (std::size_t p = 0; p < max_pressers; ++p)
    if (force_[p].largest > 0) worst = std::max(worst, force_[p].error / force_[p].largest);
  return largest > 0 ? std::max(worst, force_[max_pressers].error / largest) : unknown_ ? 1 : 0;
}

const char* doubtText(Doubt doubt) {
  switch (doubt) {
    case Doubt::None:
      return "";
    case Doubt::Resolution:
      return "the nodes are too far apart for how the tissue deforms: finer spacing there (mtled fit), or a wider "
             "tool; where mass_scaling slows what moves, a slower hand; where the skin slips off in jerks, less "
             "friction";
    case Doubt::Volume:
      return "the tissue's volume is under too high a pressure to be held: press less, or finer spacing";
    case Doubt::Contact:
      return "the tool is deep in the skin, or has let go of it, or bodies are deep in one another: finer spacing, or "
             "a blunter tool; where contact_overflow is flagged, more skin touches than there is memory for";
    case Doubt::Squeezed:
      return "a point is squeezed to less than 0.3 of its volume: press less, or finer spacing";
    case Doubt::Step:
      return "the tissue is too stiff for the time step and is slowed to stay stable: press slower, or lower "
             "dynamics.step_safety";
    case Doubt::Energy:
      return "energy comes from nowhere: lower dynamics.step_safety";
    case Doubt::Inverted:
      return "a point is inside out: press less";
    case Doubt::Lost:
      return "the solution is lost: reset";
  }
  return "";
}

const char* doubtName(Doubt doubt) {
  switch (doubt) {
    case Doubt::None:
      return "good";
    case Doubt::Resolution:
      return "resolution";
    case Doubt::Volume:
      return "volume";
    case Doubt::Contact:
      return "contact";
    case Doubt::Squeezed:
      return "squeezed";
    case Doubt::Step:
      return "step";
    case Doubt::Energy:
      return "energy";
    case Doubt::Inverted:
      return "inverted";
    case Doubt::Lost:
      return "lost";
  }
  return "";
}

Doubt doubtNamed(std::string_view name) {
  for (int d = 0; d <= static_cast<int>(Doubt::Lost); ++d)
    if (name == doubtName(static_cast<Doubt>(d))) return static_cast<Doubt>(d);
  return Doubt::None;
}

double stepShare(const Model& model, const LiveParameters& live, const ForceReport& forces) {
  return std::sqrt(stiffening(model, live)) * stepShare(model, forces);
}

double stepShare(const Model& model, const ForceReport& forces) {
  // The largest root of s^2 + 2 / s = |cof F|^2, the other two singular values being taken as equal.
  const double a = std::max(forces.max_cof2, 3.0), r = std::sqrt(3 / a);
  const double s = 2 / r * std::cos(std::acos(-r * r * r) / 3);
  const double modulus = forces.max_modulus + forces.max_squeeze * (s * s - 1);  // of that at rest
  return model.dt / model.dt_critical * std::sqrt(std::max(modulus, 1.0));
}

}  // namespace palpate
