#include "model/model_hash.h"

#include "base/instruction_set.h"
#include "base/key.h"
#include "mechanics/materials/material_law.h"
#include "model/model.h"
#include "model/state.h"

namespace palpate {
namespace {

void add(ByteKey& key, const KernelLayout& kernel) {
  key.add(chosenInstructionSet());  // its rounding depends on it
  key.add(kernel.node, kernel.short_node, kernel.gradN, kernel.rounded_gradN, kernel.scale, kernel.volume);
  key.add(kernel.batch_material, kernel.patch_begin, kernel.patch_point, kernel.patch_node);
  key.add(kernel.patch_share, kernel.patch_weight);
  if (!kernel.shear_share.empty()) key.add(kernel.shear_share, kernel.bulk_share);  // none: hashes are those of before
  const CellVolumeOf<float>& cells = kernel.cell_volume;
  key.add(cells.row_node, cells.row_N, cells.cell_node, cells.edge);
  if (!cells.empty()) key.add(cells.share, cells.limit);
}

void add(ByteKey& key, const BoundaryMotion& m) {
  key.add(m.translation, m.axis_point, m.axis, m.angle, m.duration, m.curve.kind, m.curve.time, m.curve.fraction);
}

void add(ByteKey& key, const EssentialBoundary& boundary) {
  for (const EssentialBoundary::Set& set : boundary.sets)
    key.add(set.mask, set.node, set.boundary, set.phi.value, set.v.value, set.u.value);
  for (const BoundaryMotion& m : boundary.motions) add(key, m);
}

void add(ByteKey& key, const RigidBodies& bodies) {
  key.add(bodies.vertex, bodies.area, bodies.correction);
  for (const RigidBody& body : bodies.body) {
    const RigidShape& shape = body.shape;
    if (shape.kind == RigidShape::Kind::Surface)
      key.add(shape.grid.origin, shape.grid.cell, shape.grid.gap);
    else
      key.add(shape.kind, shape.point, shape.normal, shape.half, shape.radius, shape.height);
    if (!body.encloses || body.friction > 0) key.add(body.encloses, body.friction);  // else as a skull's was
    if (body.motion.moves()) add(key, body.motion);
  }
}

void add(ByteKey& key, const SurfaceLoads& loads) {
  for (const SurfaceLoads::Course& c : loads.course) key.add(c.duration, c.curve.kind, c.curve.time, c.curve.fraction);
  key.add(loads.pressure, loads.dead, loads.X, loads.begin, loads.node, loads.N);
  for (const SurfaceLoads::Face& f : loads.face) key.add(f.vertex, f.load);
  key.add(loads.node_begin, loads.node_face, loads.R);
}

void add(ByteKey& key, const ToolShape& tool) { key.add(tool.kind, tool.radius, tool.length, tool.parameter); }

/// What is set live and differs from the model, each setting after its number; the patches' moduli follow from it.
std::string liveChanges(const Model& model, const LiveParameters& live) {
  ByteKey changes;
  for (std::size_t t = 0; t < model.tools.tool.size(); ++t)
    if (live.friction[t] != model.tools.tool[t].friction)
      changes.add(t == 0 ? -1 : -3 - static_cast<int>(t), live.friction[t]);
  if (const LiveLoads& loads = live.loads; loads.any()) {
    for (const VertexValues* values : {&loads.forces, &loads.pins}) {
      changes.add(values == &loads.forces ? -2 : -3, values->count);
      for (std::size_t k = 0; k < static_cast<std::size_t>(values->count); ++k)
        changes.add(values->vertex[k], toVec3(values->value[k]));
    }
    changes.add(loads.gravity);
    for (const Vec3& shift : loads.region_shift.of) changes.add(shift);
  }
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    if (live.kernel.materials[m] == model.materials[m]) continue;
    changes.add(static_cast<int>(m));
    add(changes, live.kernel.materials[m]);
  }
  return changes.bytes();
}

/// What a tool's contact remembers. @param add  gets bytes and their number
template <class Add>
void addContact(const ContactState& contact, const Add& add) {
  const auto contacts = static_cast<std::size_t>(contact.count);
  add(contact.vertex.data(), contacts * sizeof(int));
  add(contact.force.data(), contacts * sizeof(Float4));
  add(contact.normal.data(), contacts * sizeof(Vec3f));
  for (std::size_t k = 0; k < contacts; ++k)
    if (!contact.side[k].isZero()) add(&k, sizeof k), add(&contact.side[k], sizeof(Vec3f));
  if (const FaceSamples& samples = contact.samples; samples.longest_edge > 0) {
    const auto count = static_cast<std::size_t>(samples.count);
    add(samples.id.data(), count * sizeof(int));
    add(samples.force.data(), count * sizeof(Float4));
    add(samples.normal.data(), count * sizeof(Vec3f));
    add(samples.side.data(), count * sizeof(Vec3f));
    add(&samples.longest_edge, sizeof(float));
    add(&samples.largest_stretch, sizeof(float));
  }
}

}  // namespace

std::uint64_t modelHash(const Model& model) {
  ByteKey key;
  key.add(model.X, model.point_X, model.inverse_mass);
  add(key, model.kernel);
  for (const Material& m : model.materials) add(key, m);
  add(key, model.boundary);
  if (!model.weight.empty()) key.add(model.weight);  // none: hashes are those of before
  if (!model.surface_loads.empty()) add(key, model.surface_loads);
  key.add(model.skin.surface.vertices, model.skin.area, model.skin.node, model.skin.N, model.skin.layer);
  if (model.bodies.several()) key.add(model.bodies.body, model.bodies.friction);
  if (!model.rigid.empty()) add(key, model.rigid);  // none: hashes are those of before
  key.add(model.scene.dynamics.damping, model.scene.dynamics.rate_hz, model.dt, model.substeps_per_tick,
          model.max_increment);
  for (const ToolBody& body : model.tools.body) {
    key.add(body.tool, body.side);
    add(key, body.shape);
  }
  for (const ToolSetUp& tool : model.tools.tool) {
    key.add(tool.start.pose.position, tool.start.pose.orientation.coeffs(), tool.start.opening);
    key.add(tool.max_speed, tool.max_force, tool.grip_force, tool.friction, tool.path.size());
    for (const ToolPosture& p : tool.path) key.add(p.pose.position, p.pose.orientation.coeffs(), p.opening);
  }
  key.add(model.stiffness_means.points.weight, model.stiffness_means.nodes.weight, model.stiffness_means.bounded);
  return key.hash();
}

std::uint64_t stateHash(const Model& model, const State& state) {
  std::uint64_t hash = fnv1a({});
  const auto add = [&](const void* data, std::size_t size) {
    hash = fnv1a({static_cast<const char*>(data), size}, hash);
  };
  add(&state.tick, sizeof state.tick);
  add(&state.step, sizeof state.step);
  add(state.u.data(), state.u.size() * sizeof(Float4));
  add(state.du.data(), state.du.size() * sizeof(Float4));
  add(state.u_low.data(), state.u_low.size() * sizeof(Float4));
  add(state.relaxation.Z.data(), state.relaxation.Z.size() * sizeof(float));
  for (const ContactState& contact : state.contact) addContact(contact, add);
  if (const auto& skins = state.skins; !skins.moved.empty()) {
    const auto count = static_cast<std::size_t>(skins.count);
    add(skins.vertex.data(), count * sizeof(int));
    add(skins.face.data(), count * sizeof(int));
    add(skins.clearance.data(), count * sizeof(float));
    add(skins.force.data(), count * sizeof(Float4));
    add(&skins.travel, sizeof skins.travel);
    add(&skins.since_calm, sizeof skins.since_calm);
    if (!skins.calm) {
      add(skins.moved.data(), skins.moved.size() * sizeof(float));
      add(skins.unseen.data(), skins.unseen.size() * sizeof(float));
    }
  }
  add(state.rigid.force.data(), state.rigid.force.size() * sizeof(Float4));
  add(state.rigid.normal.data(), state.rigid.normal.size() * sizeof(Vec3f));
  for (const ToolPosture& tool : state.tool) {
    add(tool.pose.position.data(), sizeof(double) * 3);
    add(tool.pose.orientation.coeffs().data(), sizeof(double) * 4);
    add(&tool.opening, sizeof(double));
  }
  if (state.region_shift.any()) add(&state.region_shift, sizeof state.region_shift);
  if (state.place != no_place) add(state.place.data(), sizeof state.place);
  if (state.local_mass.active) add(state.local_mass.factor.data(), state.local_mass.factor.size() * sizeof(float));
  return fnv1a(liveChanges(model, state.live), hash);
}

}  // namespace palpate
