#include "batch/transient_solver.h"

#include <algorithm>

#include "step/node_passes.h"
#include "step/rigid_stop.h"
#include "step/trust.h"

namespace palpate {

TransientSolver::TransientSolver(const Model& model, int threads) : model_(model), body_(model, model.mass, threads) {
  body_.keepHistory(model.dt);
  for (const float share : model.own_share)
    beta_.push_back(Integrator(model.dt, share * model.scene.dynamics.damping).beta);
}

std::optional<BatchBody::Report> TransientSolver::tick(const ToolsAt& wanted, const Watch& watch) {
  const double h = model_.dt;
  const auto [alpha, beta, ch] = Integrator(h, model_.scene.dynamics.damping);
  const double duration = model_.substeps_per_tick * h;
  const ToolsAt tools = stoppedByRigid(model_, body_.tools(), wanted, time() + duration, duration);
  ToolsAt from = body_.tools();
  from.count = tools.count;
  if (watch) {
    u_before_ = body_.u;
    du_before_ = body_.du;
    history_before_ = body_.history();
  }
  const std::int64_t step_before = step_;
  BatchBody::Report total;
  for (int k = 1; k <= model_.substeps_per_tick; ++k) {
    if (watch && !watch()) {
      resume(step_before, u_before_, du_before_, from, history_before_);
      return {};
    }
    if (tools) body_.moveTools(between(from, tools, static_cast<double>(k) / model_.substeps_per_tick));
    ++step_;
    const auto report = body_.advance(alpha, beta, time(), beta_.empty() ? nullptr : beta_.data());
    if (report.min_J < total.min_J) {
      total.min_J = report.min_J;
      total.worst_point = report.worst_point;
    }
    total.doubt = std::max(total.doubt, report.doubt);
    if (report.step_share > TrustLimits::step_share) total.doubt = std::max(total.doubt, Doubt::Step);
    total.inverted_points = std::max(total.inverted_points, report.inverted_points);
    total.max_increment = std::max(total.max_increment, report.max_increment);
    total.finite = total.finite && report.finite;
    total.strain_energy = report.strain_energy;
    total.tool_force = report.tool_force;
    total.loads = report.loads;
    total.contact.rigid = report.contact.rigid;
  }
  total.doubt = std::max(total.doubt, body_.measureDepth(time(), total.contact.rigid));
  return total;
}

void TransientSolver::resume(std::int64_t step, const AlignedVector<Double4>& u, const AlignedVector<Double4>& du,
                             const ToolsAt& tools, const AlignedVector<double>& history) {
  step_ = step;
  body_.restore(u, du, history);
  if (tools) body_.placeTools(tools);
}

}  // namespace palpate
