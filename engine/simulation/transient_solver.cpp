#include "simulation/transient_solver.h"

#include <algorithm>

namespace palpate {

std::optional<BatchBody::Report> TransientSolver::tick(const std::optional<Pose>& tool, const Watch& watch) {
  const double h = model_.dt, c = model_.scene.damping;
  const double alpha = 2 * h * h / (2 + c * h), beta = (2 - c * h) / (2 + c * h);
  const Pose from = body_.toolPose();
  if (watch) {
    u_before_ = body_.u;
    du_before_ = body_.du;
    history_before_ = body_.history();
  }
  const std::int64_t step_before = step_;
  BatchBody::Report total;
  for (int k = 1; k <= model_.substeps_per_tick; ++k) {
    if (watch && !watch()) {
      resume(step_before, u_before_, du_before_, tool ? std::optional(from) : std::nullopt, history_before_);
      return {};
    }
    if (tool) {
      const double s = static_cast<double>(k) / model_.substeps_per_tick;
      Pose pose;
      pose.position = from.position + s * (tool->position - from.position);
      pose.orientation = from.orientation.slerp(s, tool->orientation).normalized();
      body_.moveTool(pose);
    }
    ++step_;
    const auto report = body_.advance(alpha, beta, time());
    if (report.min_J < total.min_J) {
      total.min_J = report.min_J;
      total.worst_point = report.worst_point;
    }
    total.inverted_points = std::max(total.inverted_points, report.inverted_points);
    total.max_increment = std::max(total.max_increment, report.max_increment);
    total.finite = total.finite && report.finite;
    total.tool_force = report.tool_force;
    total.skull = report.skull;
  }
  return total;
}

void TransientSolver::resume(std::int64_t step, const AlignedVector<Double4>& u, const AlignedVector<Double4>& du,
                             const std::optional<Pose>& tool, const AlignedVector<double>& history) {
  step_ = step;
  body_.restore(u, du, history);
  if (tool) body_.placeTool(*tool);
}

}  // namespace palpate
