#include "step/follow_stiffness.h"

#include <algorithm>
#include <cmath>

#include "step/trust.h"
#include "step/workspace.h"

namespace palpate {
namespace {

constexpr int parts = 8;                // fixed, so that no result depends on the threads
constexpr float kept_per_step = 0.98F;  // of a factor, where less is needed
/// Beyond this the tissue is lost, and stability no matter: it keeps what is not a number out of the masses.
constexpr float max_factor = 1e7F;

/// The largest of values[lists' entries].
float largestOf(const StiffnessMeans::Lists& lists, int list, const float* values) {
  float largest = 0;
  for (int e = lists.begin[list]; e < lists.begin[list + 1]; ++e) largest = std::max(largest, values[lists.index[e]]);
  return largest;
}

/// The factor of each node's mass that makes dt the followed share of the stable step, into `need`; a bound of at most
/// 1 where the node has mass enough. Returns the largest of the nodes that share a factor.
float computeNeeds(const Model& model, Workspace& workspace) {
  constexpr int group_size = StiffnessMeans::group_size;
  const StiffnessMeans& means = model.stiffness_means;
  LocalMassScratch& scratch = workspace.local_mass;
  const int nodes = model.nodeCount();
  const double rest = model.dt / model.dt_critical / followed_step_share;
  shareRows(workspace.team, parts, scratch.squeezed.size(), [&](int, int begin, int end) {
    for (int b = begin; b < end; ++b) {
      const auto m = static_cast<std::size_t>(model.kernel.batch_material[b]), at = static_cast<std::size_t>(b) * 16;
      const auto scale = static_cast<float>(rest * rest / model.materials[m].waveModulus());
      const KernelScratch& k = workspace.kernel;
      float* const need = &scratch.point[at];
      const float largest_squeeze = *std::max_element(&k.squeeze[at], &k.squeeze[at] + 16),
                  largest_other = *std::max_element(&k.other[at], &k.other[at] + 16);
      const float enough = scale * (hardly_squeezed_s2 * largest_squeeze + largest_other);
      scratch.squeezed[b] = !(enough <= 1) || !hardlySqueezed(&k.cof2[at], &k.J[at]);
      if (scratch.squeezed[b]) {
        squeezedModulus(&k.cof2[at], &k.J[at], &k.squeeze[at], &k.other[at], need);
        std::for_each_n(need, 16, [scale](float& c) { c *= scale; });
      } else {
        std::fill_n(need, 16, enough);
      }
    }
  });
  shareRows(workspace.team, parts, scratch.group.size(), [&](int, int begin, int end) {
    for (int g = begin; g < end; ++g) {
      bool squeezed = false;
      float bound = 0;
      for (int e = means.batches.begin[g]; e < means.batches.begin[g + 1]; ++e) {
        squeezed |= scratch.squeezed[means.batches.index[e]] != 0;
        bound = std::max(bound, scratch.point[static_cast<std::size_t>(means.batches.index[e]) * 16]);
      }
      if (squeezed) bound = 0;
      for (int i = g * group_size; i < std::min(nodes, (g + 1) * group_size); ++i) {
        scratch.node[i] = squeezed ? means.points.mean(i, scratch.point.data()) : bound;
        bound = std::max(bound, scratch.node[i]);
      }
      scratch.group[g] = bound;
    }
  });
  float bounded[parts];
  shareRows(workspace.team, parts, scratch.group.size(), [&](int part, int begin, int end) {
    bounded[part] = 0;
    for (int g = begin; g < end; ++g) {
      const float bound = largestOf(means.groups, g, scratch.group.data());
      for (int i = g * group_size; i < std::min(nodes, (g + 1) * group_size); ++i) {
        const float need = bound <= 1 ? bound : means.nodes.mean(i, scratch.node.data());
        scratch.need[i] = need <= max_factor ? need : max_factor;  // also where it is not a number
        if (means.bounded[i]) bounded[part] = std::max(bounded[part], scratch.need[i]);
      }
    }
  });
  return *std::max_element(bounded, bounded + parts);
}

/// Whether dt could be too long: a point would need mass that had both the largest |cof F|^2 and the least J of all,
/// and the largest moduli.
bool mayNeedMass(const Model& model, const LiveParameters& live, const ForceReport& forces) {
  const double rest = model.dt / model.dt_critical / followed_step_share;
  float cof2[16], J[16], squeeze[16], other[16], modulus[16];
  std::fill_n(cof2, 16, static_cast<float>(std::max(forces.max_cof2, 3.0)));
  std::fill_n(J, 16, std::min(forces.min_J, 1.0F));
  std::fill_n(squeeze, 16, static_cast<float>(forces.max_squeeze));
  std::fill_n(other, 16, static_cast<float>(forces.max_modulus - forces.max_squeeze));
  squeezedModulus(cof2, J, squeeze, other, modulus);
  double stiffer = 0;
  for (std::size_t m = 0; m < model.materials.size(); ++m)  // hundreds where tissue mixes
    stiffer = std::max(stiffer, live.kernel.materials[m].waveModulus() / model.materials[m].waveModulus());
  return !(rest * rest * stiffer * modulus[0] <= 1);
}

}  // namespace

StepMasses followStiffness(const Model& model, const Integrator& integrator, const ForceReport& forces, State& state,
                           Workspace& workspace) {
  StepMasses masses{model.inverse_mass.data(), nullptr, nullptr, integrator.alpha, 0, 0};
  masses.step_share = stepShare(model, state.live, forces);
  LocalMass& local = state.local_mass;
  if (!(masses.step_share > followed_step_share) && !local.active && !mayNeedMass(model, state.live, forces))
    return masses;

  const StiffnessMeans& means = model.stiffness_means;
  LocalMassScratch& scratch = workspace.local_mass;
  const float bounded_need = computeNeeds(model, workspace);
  const double ch = integrator.ch;
  double added_of[parts], own_of[parts];
  float needed_of[parts];
  shareRows(workspace.team, parts, local.factor.size(), [&](int part, int begin, int end) {
    double added = 0, own = 0;
    float needed = 0;
    for (int i = begin; i < end; ++i) {
      const float need = means.bounded[i] ? bounded_need : scratch.need[i];
      const float old = local.factor[i], now = std::max({1.0F, need, kept_per_step * old});
      needed = std::max(needed, need / now);
      own += model.own_mass[i];
      if (now == 1.0F && old == 1.0F) {  // most nodes
        scratch.kept[i] = 1.0F;
        scratch.inverse[i] = model.inverse_mass[i];
        continue;
      }
      local.factor[i] = now;
      scratch.kept[i] = now > old ? old / now : 1.0F;
      // The model's own mass is damped, what is added is not: m f u'' + c m u' = f_i.
      scratch.inverse[i] = model.inverse_mass[i] * static_cast<float>((2 + ch) / (2 * now + ch));
      added += model.mass[i] * (static_cast<double>(now) - 1);
    }
    added_of[part] = added;
    own_of[part] = own;
    needed_of[part] = needed;
  });
  double added = 0, own = 0;
  float needed = 0;
  for (int part = 0; part < parts; ++part) {
    own += own_of[part];
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
  masses.added = added / own;
  return masses;
}

}  // namespace palpate
