#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "base/spin_team.h"
#include "base/types.h"
#include "model/model.h"
#include "step/apply_loads.h"
#include "step/holding_friction.h"
#include "step/limit_compression.h"
#include "step/resolution.h"

namespace palpate {

/// Scratch of followStiffness: factors that points, their means around nodes, the largest of those in a group, and
/// nodes' rows need.
struct LocalMassScratch {
  LocalMassScratch(std::size_t nodes, const KernelLayout& kernel, const StiffnessMeans& means)
      : squeezed(kernel.batch_material.size()),
        point(kernel.point.size()),
        node(nodes),
        group(means.groups.begin.size() - 1),
        need(nodes),
        kept(nodes),
        inverse(nodes) {}
  AlignedVector<std::uint8_t> squeezed;  // (batch_count) 0: all its points need the same little
  AlignedVector<float> point, node, group, need;
  AlignedVector<float> kept, inverse;  // of StepMasses
};

/// Scratch of all contacts: of skins that touch, and of each of the tools' bodies.
struct ContactWorkspace {
  explicit ContactWorkspace(const Model& model)
      : skins(model.bodies, model.skin), tools(model.tools.body.size(), ContactScratch(model.skin)) {}
  SkinContactScratch skins;
  std::vector<ContactScratch> tools;  // (body_count)
};

/// How deep rigid bodies are in the skin, which is looked at by shares.
class RigidDepth {
 public:
  /// @param begins  with this share a round begins
  /// @param loads   of a tick; receive the deepest of this round and the last
  void keep(bool begins, RigidLoads& loads) {
    for (std::size_t b = 0; b < loads.size(); ++b) {
      if (begins) last_[b] = std::exchange(present_[b], 0);
      present_[b] = std::max(present_[b], loads[b].max_penetration);
      loads[b].max_penetration = std::max(last_[b], present_[b]);
    }
  }

 private:
  std::array<double, max_rigid_bodies> present_{}, last_{};  // m
};

/// Scratch memory and worker threads for stepping one model. All memory is taken here.
class Workspace {
 public:
  /// @param threads  physics threads, the stepping one included (>= 1). The result of
  ///                 a step does not depend on it.
  Workspace(const Model& model, int threads) : Workspace(model, std::make_shared<SpinTeam>(threads)) {}

  /// Of threads that step other models, too, one after the other.
  /// @param contact_beside  of such a model with the same skin and tools; null: its own
  Workspace(const Model& model, std::shared_ptr<SpinTeam> threads,
            std::shared_ptr<ContactWorkspace> contact_beside = nullptr)
      : shared_team(std::move(threads)),
        shared_contact(contact_beside ? std::move(contact_beside) : std::make_shared<ContactWorkspace>(model)),
        team(*shared_team),
        contact(*shared_contact),
        kernel(makeKernelScratch(model.kernel)),
        boundary(makeBoundaryScratch(model.boundary)),
        f(model.X.size()),
        previous_du(model.X.size()),
        local_mass(model.X.size(), model.kernel, model.stiffness_means),
        compression(model),
        holding_friction(model),
        resolution(model),
        tissue_mass(tissueMass(model)),
        surface_loads(model.surface_loads) {}

  const std::shared_ptr<SpinTeam> shared_team;
  const std::shared_ptr<ContactWorkspace> shared_contact;
  SpinTeam& team;
  ContactWorkspace& contact;
  KernelScratch kernel;
  BoundaryScratch boundary;
  AlignedVector<Float4> f;            // (node_count) internal forces, N
  AlignedVector<Float4> previous_du;  // (node_count) increments of the step before, m
  LocalMassScratch local_mass;
  CompressionLimit compression;
  HoldingFriction holding_friction;
  ResolutionWatch resolution;
  RigidDepth depth;
  const AlignedVector<float> tissue_mass;  // (node_count) kg, that live loads accelerate
  SurfaceLoadScratch surface_loads;
  VertexValues pin_force;  // N, of LiveLoads::pins on the tissue in the last step
};

/// For internalForces: by what a state's contacts hold. Real-time.
inline void findHoldingFriction(const Model& model, const State& state, Workspace& workspace) {
  workspace.holding_friction.find(model, state.contact, state.live.friction, state.skins, state.rigid,
                                  workspace.kernel.cell_volume.friction);
}

}  // namespace palpate
