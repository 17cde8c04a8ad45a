#pragma once

#include <functional>
#include <optional>

#include "batch/batch_body.h"

namespace palpate {

/// The physical motion of a model in double, by paper eq. 12 with its own masses and damping.
class TransientSolver {
 public:
  TransientSolver(const Model& model, int threads);

  /// Called before each step; false interrupts.
  using Watch = std::function<bool()>;

  /// One tick (model.substeps_per_tick steps of model.dt); the worst that its steps saw, and the last one's force.
  /// Nothing where it was interrupted: time and motion are then those at the end of the tick before.
  /// @param tools  where they are at the tick's end; without, there are none
  std::optional<BatchBody::Report> tick(const ToolsAt& tools, const Watch& watch);
  BatchBody::Report tick(const ToolsAt& tools = {}) { return *tick(tools, Watch{}); }

  const BatchBody& body() const { return body_; }
  double time() const { return static_cast<double>(step_) * model_.dt; }
  /// Goes on from a state that was saved. @param history  body().history() then
  void resume(std::int64_t step, const AlignedVector<Double4>& u, const AlignedVector<Double4>& du,
              const ToolsAt& tools, const AlignedVector<double>& history = {});
  std::int64_t step() const { return step_; }

 private:
  const Model& model_;
  BatchBody body_;
  std::vector<double> beta_;  // (node_count) of each node's own mass; empty: one for all
  std::int64_t step_ = 0;
  AlignedVector<Double4> u_before_, du_before_;  // the present tick, where it is watched
  AlignedVector<double> history_before_;
};

}  // namespace palpate
