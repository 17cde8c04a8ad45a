#include <type_traits>

#include "simulation/preparation.h"

namespace palpate {
namespace {

/// Appends values as bytes, lists with their length, so that no two scenes read alike.
class Key {
 public:
  template <class T>
  void add(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);  // no padding
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(const Vec3& v) {
    for (int c = 0; c < 3; ++c) add(v[c]);
  }
  void add(const std::vector<double>& list) {
    add(list.size());
    for (const double value : list) add(value);
  }
  void add(const Region& r) {
    add(r.kind);
    for (const Vec3& v : {r.point, r.normal, r.min, r.max}) add(v);
    for (const double value : {r.radius, r.height, r.distance}) add(value);
  }
  void add(const MaterialSpec& m) {
    add(m.kind);
    for (const double value : {m.young, m.poisson, m.ogden_D1, m.barrier_strength, m.barrier_J0, m.density}) add(value);
    add(m.ogden_mu);
    add(m.ogden_alpha);
    add(m.everywhere);
    add(m.region);
  }
  void add(const BoundarySpec& b) {
    add(b.region);
    for (const bool imposed : b.component) add(imposed);
    for (const Vec3& v : {b.translation, b.axis_point, b.axis}) add(v);
    add(b.angle);
    add(b.duration);
    add(b.curve.kind);
    add(b.curve.time);
    add(b.curve.fraction);
    add(b.surface_only);
  }
  void add(const RefineSpec& r) {
    add(r.centre);
    for (const double value : {r.radius, r.spacing, r.blend}) add(value);
  }
  template <class T>
  void addEach(const std::vector<T>& list) {
    add(list.size());
    for (const T& item : list) add(item);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

}  // namespace

std::string preparationKey(const Scene& scene, const TriangleSurface& organ) {
  Key key;
  key.addEach(organ.vertices);
  key.add(organ.triangles.size());
  for (const auto& triangle : organ.triangles)
    for (const int v : triangle) key.add(v);

  key.add(scene.spacing);
  key.add(scene.seed);
  key.add(scene.quadrature.points_per_cell);
  key.add(scene.quadrature.accuracy);
  key.add(scene.quadrature.division);
  key.add(scene.quadrature.max_depth);
  key.add(scene.basis_degree);
  key.add(scene.support_factor);
  key.add(scene.mu);
  key.add(scene.consistent_gradients);
  key.add(scene.node_patch_volume);
  key.add(scene.boundary_method);
  key.addEach(scene.refine);
  key.addEach(scene.materials);
  key.addEach(scene.boundaries);
  key.add(scene.tool.radius);  // the skin is as fine as the tool needs
  if (scene.mass_scaling > 0)
    for (const double value : {scene.mass_scaling, scene.rate_hz, scene.time_step, scene.step_safety, scene.tool_max_speed}) key.add(value);
  return key.take();
}

}  // namespace palpate
