#include "simulation/live_loads.h"

#include <algorithm>

#include "base/float4.h"
#include "contact/skin_forces.h"
#include "simulation/follow_stiffness.h"
#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

bool LiveLoads::operator==(const LiveLoads& other) const {
  const auto same = [](const Float4& a, const Float4& b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  return gravity == other.gravity && count == other.count && vertex == other.vertex &&
         std::equal(force.begin(), force.begin() + count, other.force.begin(), same);
}

bool LiveLoads::setForce(int at, const Vec3& newtons) {
  const auto end = vertex.begin() + count;
  const auto place = std::lower_bound(vertex.begin(), end, at);
  const auto k = static_cast<std::size_t>(place - vertex.begin());
  const bool there = place != end && *place == at, wanted = !newtons.isZero(0);
  const auto last = force.begin() + count;
  if (there && !wanted) {
    std::move(place + 1, end, place);
    std::move(force.begin() + static_cast<std::ptrdiff_t>(k) + 1, last, force.begin() + static_cast<std::ptrdiff_t>(k));
    --count;
    vertex[static_cast<std::size_t>(count)] = 0;
    force[static_cast<std::size_t>(count)] = {};
  } else if (!there && wanted) {
    if (count == max_forces) return false;
    std::move_backward(place, end, end + 1);
    std::move_backward(force.begin() + static_cast<std::ptrdiff_t>(k), last, last + 1);
    ++count;
  }
  if (wanted) vertex[k] = at, force[k] = toFloat4(newtons);
  return true;
}

AlignedVector<float> tissueMass(const Model& model) {
  std::vector<double> mass(model.X.size(), 0);
  const ShapeTable& shape = model.point_shape;
  for (int q = 0; q < model.pointCount(); ++q) {
    const double of_point = model.point_volume[q] * model.materials[model.point_material[q]].density;
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) mass[shape.node[e]] += of_point * shape.N[e];
  }
  return AlignedVector<float>(mass.begin(), mass.end());
}

void addLoads(const Model& model, const AlignedVector<float>& tissue_mass, double alpha, const StepMasses& masses,
              State& state) {
  const LiveLoads& loads = state.live.loads;
  const auto a = static_cast<float>(alpha);
  if (!loads.gravity.isZero(0)) {
    const Group g = load(toFloat4(loads.gravity));
    for (std::size_t i = 0; i < tissue_mass.size(); ++i)
      store(state.du[i], load(state.du[i]) + a * masses.inverse[i] * tissue_mass[i] * g);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(loads.count); ++k) {
    const Float4& f = loads.force[k];
    applyForce(model.skin, loads.vertex[k], Eigen::Vector4f(f.x, f.y, f.z, 0), a, masses.inverse, state.du.data());
  }
}

}  // namespace palpate
