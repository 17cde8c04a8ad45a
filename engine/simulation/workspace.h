#pragma once

#include "base/spin_team.h"
#include "base/types.h"
#include "simulation/model.h"

namespace palpate {

/// Scratch memory and worker threads for stepping one model. All memory is taken here.
class Workspace {
 public:
  /// @param threads  physics threads, the stepping one included (>= 1). The result of
  ///                 a step does not depend on it.
  Workspace(const Model& model, int threads)
      : team(threads),
        kernel(makeKernelScratch(model.kernel)),
        boundary(makeBoundaryScratch(model.boundary)),
        f(model.X.size()),
        previous_du(model.X.size()) {}

  SpinTeam team;
  KernelScratch kernel;
  BoundaryScratch boundary;
  AlignedVector<Float4> f;            // (node_count) internal forces, N
  AlignedVector<Float4> previous_du;  // (node_count) increments of the step before, m
};

}  // namespace palpate
