#include "mtled/bench/bare_loop.h"

#include <cmath>
#include <stdexcept>

#include "base/float4.h"
#include "mechanics/internal_forces.h"
#include "mechanics/materials/laws.h"
#include "mtled/bench/frictionless_contact.h"
#include "simulation/trust.h"

namespace palpate::tools {
namespace {

const KernelPasses<float>& barePasses(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return barePassesFor<InstructionSet::Avx512>();
  if (set == InstructionSet::Avx2) return barePassesFor<InstructionSet::Avx2>();
#endif
  if (set != InstructionSet::Plain) throw std::invalid_argument("no such kernel on this architecture");
  return barePassesFor<InstructionSet::Plain>();
}

constexpr int parts = 8;  // as in simulation/step.cpp, for the same sums

}  // namespace

BareLoop::BareLoop(const Model& model, Workspace& workspace, const State& start, Contact contact)
    : model_(model), state_(start), workspace_(workspace), contact_(contact) {
  for (const Material& m : start.live.kernel.materials)
    if (m.law != lawNumber<NeoHookean>())
      throw std::invalid_argument("the bare kernel knows neo-Hookean material only");
  if (!model.kernel.patch_begin.empty()) throw std::invalid_argument("the bare kernel knows no node patches");
  passes_ = &barePasses(chosenInstructionSet());
}

StepReport BareLoop::tick() {
  if (contact_ != Contact::None)
    findContactCandidates(model_.skin, state_.u.data(), model_.scene.tool, state_.tool_pose,
                          2 * model_.scene.tool_max_speed / model_.scene.rate_hz, state_.contact);
  correctBoundaryDrift(model_.boundary, static_cast<double>(state_.step) * model_.dt, state_.u.data(),
                       state_.u_low.data(), workspace_.boundary);
  const KernelPasses<float>* all = workspace_.kernel.passes;
  workspace_.kernel.passes = passes_;
  StepReport report;
  for (int k = 0; k < model_.substeps_per_tick; ++k) report = step();
  workspace_.kernel.passes = all;
  ++state_.tick;
  return report;
}

StepReport BareLoop::step() {
  const double h = model_.dt, c = model_.scene.damping, alpha = 2 * h * h / (2 + c * h);
  const auto alpha_f = static_cast<float>(alpha), beta = static_cast<float>((2 - c * h) / (2 + c * h));
  const ForceReport forces =
      internalForces(model_.kernel, state_.live.kernel, state_.u.data(), workspace_.kernel, workspace_.team);
  const auto border = [n = std::int64_t{model_.nodeCount()}](int part) { return static_cast<int>(n * part / parts); };

  double before = 0;
  for (int part = 0; part < parts; ++part) {
    sumForces(model_.kernel, workspace_.kernel, border(part), border(part + 1), workspace_.f.data());
    Group work{};
    for (int i = border(part); i < border(part + 1); ++i) {
      const Group du = load(state_.du[i]), f = load(workspace_.f[i]);
      work += f * du;
      workspace_.previous_du[i] = state_.du[i];
      store(state_.du[i], beta * du + alpha_f * model_.inverse_mass[i] * f);
    }
    before += static_cast<double>(work[0]) + work[1] + work[2];
  }
  state_.energy.work -= 0.5 * before;

  StepReport report;
  if (contact_ == Contact::Frictionless)
    report.tool_force =
        frictionlessContact(model_.skin, model_.scene.tool, state_.tool_pose, state_.tool_pose, alpha,
                            model_.inverse_mass.data(), state_.u.data(), state_.du.data(), state_.contact);
  report.base_reaction =
      imposeBoundary(model_.boundary, static_cast<double>(state_.step + 1) * h, h, alpha, model_.inverse_mass.data(),
                     nullptr, state_.du.data(), workspace_.boundary, workspace_.team);

  double after = 0, kinetic = 0, acceleration = 0;
  float furthest = 0;
  bool finite = true;
  for (int part = 0; part < parts; ++part) {
    Group work{};
    float kinetic_part = 0, acceleration_part = 0;
    for (int i = border(part); i < border(part + 1); ++i) {
      const Group du = load(state_.du[i]), u = load(state_.u[i]);
      const Group y = du + load(state_.u_low[i]), t = u + y;
      store(state_.u_low[i], y - (t - u));
      store(state_.u[i], t);
      work += load(workspace_.f[i]) * du;
      const float d2 = du[0] * du[0] + du[1] * du[1] + du[2] * du[2];
      if (d2 > furthest) {
        furthest = d2;
        report.worst_node = i;
      }
      const Group change = du - load(workspace_.previous_du[i]);
      const auto mass = static_cast<float>(model_.mass[i]);
      kinetic_part += mass * d2;
      acceleration_part += mass * (change[0] * change[0] + change[1] * change[1] + change[2] * change[2]);
      if (!(d2 <= 1e30F)) finite = false;
    }
    after += static_cast<double>(work[0]) + work[1] + work[2];
    kinetic += kinetic_part;
    acceleration += acceleration_part;
  }
  report.max_increment = std::sqrt(furthest);
  report.kinetic_energy = 0.5 * kinetic / (h * h);
  report.strain_energy = forces.strain_energy;
  report.energy_error = state_.energy.update(forces.strain_energy, report.kinetic_energy, acceleration / (8 * h * h), h,
                                             model_.rest_energy);
  state_.energy.work -= 0.5 * after;
  report.volume_change = forces.volume_change / model_.cell_volume;
  report.step_share = stepShare(model_, state_.live, forces);
  report.min_J = forces.min_J;
  if (!finite) report.flags |= kNotFinite;
  if (report.max_increment > model_.max_increment) report.flags |= kBlowUp;
  if (forces.inverted_points > 0) report.flags |= kInvertedPoints;
  ++state_.step;
  return report;
}

}  // namespace palpate::tools
