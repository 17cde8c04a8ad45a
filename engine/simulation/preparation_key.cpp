#include "base/key.h"
#include "simulation/preparation.h"

namespace palpate {
namespace {

void add(ByteKey& key, const Region& r) {
  key.add(r.kind, r.point, r.normal, r.min, r.max, r.radius, r.height, r.distance);
}

void add(ByteKey& key, const MaterialSpec& m) {
  key.add(m.kind, m.young, m.poisson, m.ogden_D1, m.barrier_strength, m.barrier_J0, m.density, m.ogden_mu,
          m.ogden_alpha);
  key.add(m.everywhere);
  add(key, m.region);
}

void add(ByteKey& key, const BoundarySpec& b) {
  add(key, b.region);
  key.add(b.component[0], b.component[1], b.component[2]);
  key.add(b.translation, b.axis_point, b.axis, b.angle, b.duration);
  key.add(b.curve.kind, b.curve.time, b.curve.fraction, b.surface_only);
}

void add(ByteKey& key, const RefineSpec& r) { key.add(r.centre, r.radius, r.spacing, r.blend); }

template <class T>
void addEach(ByteKey& key, const std::vector<T>& list) {
  key.add(list.size());
  for (const T& item : list) add(key, item);
}

}  // namespace

std::string preparationKey(const Scene& scene, const TriangleSurface& organ) {
  ByteKey key;
  key.add(organ.vertices, organ.triangles);
  key.add(scene.spacing, scene.seed);
  key.add(scene.quadrature.points_per_cell, scene.quadrature.cells_per_point, scene.quadrature.accuracy,
          scene.quadrature.division, scene.quadrature.max_depth);
  key.add(scene.basis_degree, scene.support_factor, scene.mmls_weight, scene.consistent_gradients,
          scene.node_patch_volume);
  key.add(scene.boundary_method);
  addEach(key, scene.refine);
  addEach(key, scene.materials);
  addEach(key, scene.boundaries);
  key.add(scene.tool.radius);  // the skin is as fine as the tool needs
  if (scene.mass_scaling > 0)
    key.add(scene.mass_scaling, scene.rate_hz, scene.time_step, scene.step_safety, scene.tool_max_speed);
  return key.bytes();
}

}  // namespace palpate
