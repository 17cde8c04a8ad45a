#include "simulation/follow_stiffness.h"

#include <algorithm>
#include <cmath>

#include "simulation/trust.h"
#include "simulation/workspace.h"

namespace palpate {
namespace {

constexpr int parts = 8;                // fixed, so that no result depends on the threads
constexpr float kept_per_step = 0.98F;  // of a factor, where less is needed
/// Beyond this the tissue is lost, and stability no matter: it keeps what is not a number out of the masses.
constexpr float max_factor = 1e4F;

/// Calls each(part, begin, end) for parts of `count` numbers, whole cache lines of them.
template <class Each>
void forParts(SpinTeam& team, std::size_t count, Each each) {
  const auto border = [lines = (count + 15) / 16, count](int part) {
    return static_cast<int>(std::min(count, lines * static_cast<std::size_t>(part) / parts * 16));
  };
  shareOut(team, parts, [&](int part) { each(part, border(part), border(part + 1)); });
}

/// Weighted mean of values[index[e]] over a row's entries. Four partial sums, so that the additions overlap; their order
/// is fixed.
float mean(const std::vector<int>& begin, const std::vector<std::int32_t>& index, const AlignedVector<float>& weight,
           int row, const float* values) {
  float sum[4] = {};
  int e = begin[row];
  const int end = begin[row + 1];
  for (; e + 4 <= end; e += 4)
    for (int k = 0; k < 4; ++k) sum[k] += weight[e + k] * values[index[e + k]];
  for (; e < end; ++e) sum[0] += weight[e] * values[index[e]];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// The factor of each node's mass that makes dt the followed share of the stable step, into `need`; below 1 where the
/// node has mass enough. Returns the largest of the nodes that have theirs in common.
float computeNeeds(const Model& model, const LiveParameters& live, Workspace& workspace) {
  const StiffnessMeans& means = model.stiffness_means;
  LocalMassScratch& scratch = workspace.local_mass;
  const double rest = model.dt / model.dt_critical / followed_step_share;
  forParts(workspace.team, scratch.point.size(), [&](int, int begin, int end) {
    for (int p = begin; p < end; p += 16) {
      const auto m = static_cast<std::size_t>(model.kernel.batch_material[static_cast<std::size_t>(p) / 16]);
      const double scale = rest * rest / model.materials[m].waveModulus();
      squeezedModulus(&workspace.kernel.cof2[p], &workspace.kernel.J[p], 16,
                      static_cast<float>(scale * live.kernel.materials[m].bulk_modulus),
                      static_cast<float>(scale * live.kernel.materials[m].shear_modulus), &scratch.point[p]);
    }
  });
  forParts(workspace.team, scratch.node.size(), [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i)
      scratch.node[i] = mean(means.point_begin, means.point, means.point_weight, i, scratch.point.data());
  });
  float bounded[parts];
  forParts(workspace.team, scratch.need.size(), [&](int part, int begin, int end) {
    bounded[part] = 0;
    for (int i = begin; i < end; ++i) {
      const float need = mean(means.node_begin, means.node, means.node_weight, i, scratch.node.data());
      scratch.need[i] = need <= max_factor ? need : max_factor;  // also where it is not a number
      if (means.bounded[i]) bounded[part] = std::max(bounded[part], scratch.need[i]);
    }
  });
  return *std::max_element(bounded, bounded + parts);
}

}  // namespace

StepMasses followStiffness(const Model& model, const Integrator& integrator, const ForceReport& forces, State& state,
                           Workspace& workspace) {
  StepMasses masses{model.inverse_mass.data(), nullptr, nullptr, integrator.alpha, 0, 0};
  masses.step_share = stepShare(model, state.live, forces.max_cof2);
  LocalMass& local = state.local_mass;
  if (!(masses.step_share > followed_step_share) && !local.active) return masses;

  const StiffnessMeans& means = model.stiffness_means;
  LocalMassScratch& scratch = workspace.local_mass;
  const float bounded_need = computeNeeds(model, state.live, workspace);
  const double ch = integrator.ch;
  double added_of[parts], mass_of[parts];
  float needed_of[parts];
  forParts(workspace.team, local.factor.size(), [&](int part, int begin, int end) {
    double added = 0, mass = 0;
    float needed = 0;
    for (int i = begin; i < end; ++i) {
      const float need = means.bounded[i] ? bounded_need : scratch.need[i];
      const float old = local.factor[i], now = std::max({1.0F, need, kept_per_step * old});
      local.factor[i] = now;
      scratch.kept[i] = now > old ? old / now : 1.0F;
      // The model's own mass is damped, what is added is not: m f u'' + c m u' = f_i.
      scratch.inverse[i] = model.inverse_mass[i] * static_cast<float>((2 + ch) / (2 * now + ch));
      added += model.mass[i] * (static_cast<double>(now) - 1);
      mass += model.mass[i];
      needed = std::max(needed, need / now);
    }
    added_of[part] = added;
    mass_of[part] = mass;
    needed_of[part] = needed;
  });
  double added = 0, mass = 0;
  float needed = 0;
  for (int part = 0; part < parts; ++part) {
    mass += mass_of[part];
    added += added_of[part];
    needed = std::max(needed, needed_of[part]);
  }
  masses.step_share =
      std::min(masses.step_share, followed_step_share * std::max(1.0, std::sqrt(static_cast<double>(needed))));
  local.active = added > 0;
  if (!local.active) return masses;
  masses.inverse = scratch.inverse.data();
  masses.factor = local.factor.data();
  masses.kept = scratch.kept.data();
  if (means.first_bounded >= 0)
    masses.boundary_alpha *= (2 + ch) / (2 * static_cast<double>(local.factor[means.first_bounded]) + ch);
  masses.added = added / mass * (1 + model.added_mass);
  return masses;
}

}  // namespace palpate
