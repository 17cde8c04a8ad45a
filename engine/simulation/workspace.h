#pragma once

#include "base/spin_team.h"
#include "base/types.h"
#include "simulation/model.h"

namespace palpate {

/// Scratch of followStiffness.
struct LocalMassScratch {
  LocalMassScratch(std::size_t nodes, std::size_t points)
      : point(points), node(nodes), need(nodes), kept(nodes), inverse(nodes) {}
  AlignedVector<float> point, node, need;  // factors that points, the patches of nodes, and nodes' rows need
  AlignedVector<float> kept, inverse;      // of StepMasses
};

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
        previous_du(model.X.size()),
        local_mass(model.X.size(), model.kernel.point.size()) {}

  SpinTeam team;
  KernelScratch kernel;
  BoundaryScratch boundary;
  AlignedVector<Float4> f;            // (node_count) internal forces, N
  AlignedVector<Float4> previous_du;  // (node_count) increments of the step before, m
  LocalMassScratch local_mass;
};

}  // namespace palpate
