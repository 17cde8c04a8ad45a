#include "simulation/model_hash.h"

#include "base/instruction_set.h"
#include "base/key.h"
#include "simulation/model.h"

namespace palpate {
namespace {

void add(ByteKey& key, const KernelLayout& kernel) {
  key.add(chosenInstructionSet());  // its rounding depends on it
  key.add(kernel.node, kernel.short_node, kernel.gradN, kernel.rounded_gradN, kernel.scale, kernel.volume);
  key.add(kernel.batch_material, kernel.patch_begin, kernel.patch_point, kernel.patch_node);
  key.add(kernel.patch_share, kernel.patch_weight);
}

void add(ByteKey& key, const Material& m) {
  key.add(m.kind, m.shear_modulus, m.bulk_modulus, m.term_count, m.mu, m.alpha, m.barrier_strength, m.barrier_J0);
}

void add(ByteKey& key, const EssentialBoundary& boundary) {
  for (const EssentialBoundary::Set& set : boundary.sets)
    key.add(set.mask, set.node, set.boundary, set.phi.value, set.v.value, set.u.value);
  for (const BoundaryMotion& m : boundary.motions)
    key.add(m.translation, m.axis_point, m.axis, m.angle, m.duration, m.curve.kind, m.curve.time, m.curve.fraction);
}

void add(ByteKey& key, const ToolShape& tool) { key.add(tool.kind, tool.radius, tool.length, tool.edge_radius); }

}  // namespace

std::uint64_t modelHash(const Model& model) {
  ByteKey key;
  key.add(model.X, model.point_X, model.inverse_mass);
  add(key, model.kernel);
  for (const Material& m : model.materials) add(key, m);
  add(key, model.boundary);
  key.add(model.skin.surface.vertices, model.skin.area, model.skin.node, model.skin.N, model.skin.bulk_stiffness);
  add(key, model.scene.tool);
  key.add(model.tool_start.position, model.tool_start.orientation.coeffs(), model.scene.tool_max_speed);
  key.add(model.scene.friction, model.scene.damping, model.scene.rate_hz);
  key.add(model.dt, model.substeps_per_tick, model.max_increment);
  return key.hash();
}

}  // namespace palpate
