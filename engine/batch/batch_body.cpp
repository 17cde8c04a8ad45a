#include "batch/batch_body.h"

#include <algorithm>
#include <cmath>

#include "base/float4.h"
#include "model/live_parameters.h"
#include "model/solution_fields.h"
#include "setup/body_points.h"
#include "setup/mixtures.h"
#include "step/held_nodes.h"
#include "step/rim_force.h"
#include "step/step_report.h"
#include "step/trust.h"

namespace palpate {
namespace {

KernelLayoutOf<double> kernelInDouble(const Model& model, const std::vector<Material>& materials) {
  auto kernel = makeKernelLayout<double>(model.point_shape, model.point_X, model.point_volume, model.point_material,
                                         materials, model.nodeCount(), model.patches, GradientPrecision::Float32, {},
                                         mixtureBases(model.scene));
  if (model.hasCellVolume()) kernel.cell_volume = makeCellVolume<double>(model.cellVolume());
  return kernel;
}

double layerModulus(const Material& m) {
  return palpate::layerModulus(m.bulk_modulus, m.shear_modulus + m.fibre_modulus / 3);
}

}  // namespace

BatchBody::BatchBody(const Model& model, const std::vector<double>& mass, int threads)
    : u(model.X.size()),
      du(model.X.size()),
      f(model.X.size()),
      model_(model),
      team_(threads),
      kernel_(kernelInDouble(model, model.materials)),
      materials_(makeKernelMaterials(kernel_, model.materials)),
      kernel_scratch_(makeKernelScratch(kernel_)),
      boundary_(makeEssentialBoundary<double>(model.essential, mass)),
      boundary_scratch_(makeBoundaryScratch(boundary_)),
      load_scratch_(model.surface_loads),
      tools_(model),
      holding_friction_(model),
      skins_(makeSkinContactState(model.bodies)),
      skins_scratch_(model.bodies, model.skin),
      rigid_(makeRigidState(model.rigid, model.nodeCount())),
      u_float_(model.X.size()),
      du_float_(model.X.size()),
      du_before_(model.X.size()),
      du_held_(model.X.size()) {
  for (const double m : mass) {
    inverse_mass_.push_back(1 / m);
    inverse_mass_float_.push_back(static_cast<float>(1 / m));
  }
}

void BatchBody::setMaterials(const std::vector<Material>& materials) {
  if (!mixtureBases(model_.scene).empty()) kernel_ = kernelInDouble(model_, materials);  // has the mixtures' shares
  materials_ = makeKernelMaterials(kernel_, materials);
  if (below_.empty()) {
    skin_ = model_.skin;
    for (const int q : nearestPoints(model_, skin_.surface.vertices, model_.bodies.body))
      below_.push_back(model_.point_material[static_cast<std::size_t>(q)]);
  }
  layer_share_.clear();
  for (std::size_t m = 0; m < materials.size(); ++m)
    layer_share_.push_back(layerModulus(materials[m]) / layerModulus(model_.materials[m]));
  for (std::size_t v = 0; v < below_.size(); ++v)
    skin_.layer[v] = static_cast<float>(model_.skin.layer[v] * layerShare(static_cast<int>(v)));
}

void BatchBody::moveRegion(int region, const Vec3& shift, AlignedVector<Double4>& increment) {
  if (boundary_.motions.empty()) return;
  boundary_scratch_.moved.of[static_cast<std::size_t>(region)] = shift;
  imposeBoundary(boundary_, 0.0, 0.0, 1.0, inverse_mass_.data(), nullptr, increment.data(), boundary_scratch_, team_);
  boundary_scratch_.moved = {};
}

void BatchBody::keepHistory(double h) {
  history_ = makeRelaxationHistory<double>(kernel_.batch_material.size(), model_.materials);
  history_step_ = h;
}

PointHistory BatchBody::pointHistory() const {
  return palpate::pointHistory(kernel_, history_, model_.pointCount(), history_step_);
}

void BatchBody::restore(const AlignedVector<Double4>& displacement, const AlignedVector<Double4>& increment,
                        const AlignedVector<double>& history) {
  skins_ = makeSkinContactState(model_.bodies);
  rigid_ = makeRigidState(model_.rigid, model_.nodeCount());
  u = displacement;
  du = increment;
  if (history.empty())
    std::fill(history_.Z.begin(), history_.Z.end(), 0.0);
  else
    history_.Z = history;
}

ForceReport BatchBody::forces(const AlignedVector<Double4>& at, AlignedVector<Double4>& force) {
  return forces(at, force, nullptr);
}

ForceReport BatchBody::forces(const AlignedVector<Double4>& at, AlignedVector<Double4>& force,
                              RelaxationHistoryOf<double>* history) {
  const ForceReport report =
      internalForces(kernel_, materials_, at.data(), kernel_scratch_, team_, history, history_step_);
  sumForces(kernel_, kernel_scratch_, 0, model_.nodeCount(), force.data());
  if (layer_) layer_->addForces(at, force);
  return report;
}

void BatchBody::findFriction() {
  std::array<double, max_tools> of_tools{};
  for (std::size_t t = 0; t < model_.tools.tool.size(); ++t) of_tools[t] = model_.tools.tool[t].friction;
  holding_friction_.find(model_, tools_.contacts(), of_tools, skins_, rigid_, kernel_scratch_.cell_volume.friction);
}

void BatchBody::contact(double alpha, double time, Report& report) {
  const auto toFloat = [](const Double4& a) { return toFloat4(toVec3(a)); };
  for (std::size_t i = 0; i < u.size(); ++i) {
    u_float_[i] = toFloat(u[i]);
    du_float_[i] = du_before_[i] = toFloat(du[i]);
  }
  findSkinPairs(model_.bodies, model_.skin, u_float_.data(), du_before_.data(), 1, skins_, skins_scratch_);
  const ContactStep step{below_.empty() ? model_.skin : skin_,
                         static_cast<float>(alpha),
                         inverse_mass_float_.data(),
                         u_float_.data(),
                         du_float_.data(),
                         settled_in_batch};
  HeldNodes held([&] {
    for (std::size_t i = 0; i < u.size(); ++i)
      du_held_[i] = {du[i].x + (du_float_[i].x - du_before_[i].x), du[i].y + (du_float_[i].y - du_before_[i].y),
                     du[i].z + (du_float_[i].z - du_before_[i].z), 0};
    imposeBoundary(boundary_, time, 0.0, alpha, inverse_mass_.data(), u.data(), du_held_.data(), boundary_scratch_,
                   team_, true);
    for (std::size_t i = 0; i < u.size(); ++i) du_float_[i] = toFloat(du_held_[i]);
  });
  const bool beside_held = touchesBesideHeld(model_, tools_.contacts(), skins_, rigid_);
  report.contact = tools_.solve(step,
                                {{},
                                 beside_held ? &held : nullptr,
                                 &skins_,
                                 &skins_scratch_,
                                 layer_ ? nullptr : &model_.rigid,
                                 &rigid_,
                                 time - model_.dt,
                                 time},
                                report.loads);
  report.tool_force = report.loads[0].force;
  if (model_.bodies.several())
    for (int k = 0; k < organCount(model_); ++k)
      report.organ_force[static_cast<std::size_t>(k)] = skinForceOn(model_.bodies, model_.skin, k, skins_);
  for (std::size_t i = 0; i < u.size(); ++i)
    store(du[i], load(du[i]) + __builtin_convertvector(load(du_float_[i]) - load(du_before_[i]), GroupOf<double>));
}

Doubt BatchBody::measureDepth(double time, RigidLoads& loads) {
  if (model_.rigid.empty()) return Doubt::None;
  for (std::size_t i = 0; i < u.size(); ++i) u_float_[i] = toFloat4(toVec3(u[i]));
  addDeepest(model_.rigid, model_.skin, u_float_.data(), time, model_.bodies.spacing, 0, 1, loads);
  return isTooDeep(model_, loads) ? Doubt::Contact : Doubt::None;
}

bool BatchBody::hasContact() const {
  return tools_.present() || !areCalm(model_.bodies, skins_) || (!model_.rigid.empty() && !layer_);
}

/// As of a step of the loop that saw the same.
Doubt BatchBody::doubt(const ForceReport& forces, const Report& report) const {
  StepReport step;
  if (!report.finite) step.flags |= kNotFinite;
  if (tools_.overflow()) step.flags |= kContactOverflow;
  step.min_J = forces.min_J;
  step.inverted_points = forces.inverted_points;
  step.max_penetration = tools_.maxPenetration();
  if (isTooDeep(model_, report.contact.skins)) step.flags |= kDeepContact;
  step.volume_change = forces.volume_change / model_.cell_volume;
  step.pressure_over_shear =
      model_.patches.empty() ? -step.volume_change * bulkOverShear(model_.materials) : forces.max_patch_pressure;
  step.cell_pressure_over_shear = forces.max_cell_pressure;
  step.nearly_incompressible = nearlyIncompressible(model_.materials);
  return doubtOf(model_, step);
}

/// du += alpha M^-1 (w + surface loads at a time)
void BatchBody::addLoads(double alpha, double time) {
  const SurfaceLoads& loads = model_.surface_loads;
  if (model_.weight.empty() && loads.empty()) return;
  evaluate(loads, time, u.data(), load_scratch_, team_);
  for (std::size_t i = 0; i < u.size(); ++i) {
    GroupOf<double> force = loadOnNode(loads, load_scratch_, i);
    if (!model_.weight.empty()) force += load(model_.weight[i]);
    store(du[i], load(du[i]) + (alpha * inverse_mass_[i]) * force);
  }
}

BatchBody::Report BatchBody::advance(double alpha, double beta, double time, const double* own_beta) {
  Report report;
  alpha_ = alpha;
  findFriction();
  const ForceReport forces_report = forces(u, f, history_step_ > 0 ? &history_ : nullptr);
  report.min_J = forces_report.min_J;
  report.worst_point = forces_report.worst_point;
  report.inverted_points = forces_report.inverted_points;
  report.step_share = stepShare(model_, forces_report);
  for (std::size_t i = 0; i < u.size(); ++i)
    store(du[i], (own_beta ? own_beta[i] : beta) * load(du[i]) + (alpha * inverse_mass_[i]) * load(f[i]));
  addLoads(alpha, time);
  if (hasContact()) contact(alpha, time, report);
  if (layer_) report.contact.rigid = layer_->loads();
  imposeBoundary(boundary_, time, 0.0, alpha, inverse_mass_.data(), u.data(), du.data(), boundary_scratch_, team_);
  double largest = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const auto d = load(du[i]);
    store(u[i], load(u[i]) + d);
    const double d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    report.finite &= std::isfinite(d2);
    largest = std::max(largest, d2);
  }
  report.max_increment = std::sqrt(largest);
  noteTravel(model_.bodies, report.max_increment, du.data(), skins_);
  report.strain_energy = forces_report.strain_energy;
  report.doubt = doubt(forces_report, report);
  return report;
}

double BatchBody::rimShare(const ToolLoads& loads) const {
  return palpate::rimShare<double>(model_, tools_.contacts(), tools_.at().posture, u.data(), loads);
}

}  // namespace palpate
